// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/case_checks.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <unordered_set>

#include "kalfem/dynamics/simulate.hpp"
#include "kalfem/study/unknown_inputs_of.hpp"
#include "kalfem/system/signals/deterministic.hpp"

namespace kalfem {
namespace {

namespace d = description;

template <class T>
std::vector<std::string> names_of(const Named<T>& entries) {
  std::vector<std::string> names;
  for (const auto& [name, entry] : entries) names.push_back(name);
  return names;
}

void check_name(const Name& name, const std::string& kind, const std::vector<std::string>& known,
                const std::string& fix, IssueList& issues) {
  if (std::ranges::find(known, name.value) == known.end())
    issues.add(name.location,
               name.path + ": there is no " + kind + " '" + name.value + "'" + did_you_mean(name.value, known), "",
               fix);
}

/// The names that an entry applies to: its own if it lists no others.
template <class Entry>
std::vector<Name> targets_of(const std::string& name, const Entry& entry, const SourceLocation& place,
                             const std::string& path) {
  if (!entry.applies_to.empty()) return entry.applies_to;
  return {{name, place, path}};
}

/// The step is either fixed or refined until a tolerance is met; the case must not give keys of both.
void check_steps(const d::Simulation& given, IssueList& issues) {
  const d::Simulation defaults;
  if (given.substeps && (given.tolerance != defaults.tolerance || given.first_substeps != defaults.first_substeps ||
                         given.max_substeps != defaults.max_substeps))
    issues.add(given.substeps->location,
               given.substeps->path + " fixes the step, but tolerance, first_substeps or max_substeps is given too",
               "a fixed step is not refined", "remove `substeps` or the others");
}

void check_step_order(const d::Estimation& given, IssueList& issues) {
  if (given.step_order && given.step_order->value == 3)
    issues.add(given.step_order->location, given.step_order->path + " is 3", "the filter has steps of order 2 and 4",
               "write 2 or 4");
}

}  // namespace

void check_sections(const d::Case& given, IssueList& issues) {
  if (given.simulate) check_steps(*given.simulate, issues);
  if (given.estimate) check_step_order(*given.estimate, issues);
  check_unknown_excitations(given, issues);
  const auto place = [&](const char* section) { return given.source.at({section}); };
  if (given.simulate && given.record)
    issues.add(place("record"), "the case has both `simulate` and `record`", "there can be only one record",
               "remove one of them");
  if (given.estimate && !given.simulate && !given.record && !given.live)
    issues.add(place("estimate"), "the case has `estimate` but no record", "", "add `simulate`, `record` or `live`");
  if (given.estimate && given.sensors.empty())
    issues.add(place("estimate"), "the case has `estimate` but no sensors", "",
               "add at least one sensor under `sensors`");
  if (given.record && given.sensors.empty())
    issues.add(place("record"), "the case has a record but no sensors", "sensors state what its columns are",
               "add at least one sensor under `sensors`");
  if (given.predict && !given.estimate)
    issues.add(place("predict"), "the case has `predict` but no `estimate`",
               "the prediction is driven by the estimated boundary motion", "add `estimate`");
  if (given.substructures.empty() && !given.source.gives({"component"}))
    issues.add(place("substructures"), "substructures is empty", "the case needs a structure",
               "describe at least one substructure");
}

namespace {

constexpr const char* gauge_fix = "define it under `gauges` of the finite elements, and write substructure.name";

}  // namespace

void check_sensor_names(const d::Case& given, const CoupledModel& model, IssueList& issues) {
  const auto connectors = names_of(given.connectors), points = model.point_names(), gauges = model.gauges();
  const std::unordered_set<std::string> known_points(points.begin(), points.end());
  for (const auto& [name, sensor] : given.sensors) {
    const auto& [seen, location, path] =
        std::visit([](const auto& observed) -> const d::Points& { return observed.points; }, sensor.observed);
    const auto quantity = std::visit([](const auto& observed) { return observed.quantity; }, sensor.observed);
    for (const auto& [target, weight] : seen) {
      const Name named{target, location, path};
      if (is_of_connector(quantity))
        check_name(named, "connector", connectors, "name one of the `connectors`", issues);
      else if (quantity == ObservedQuantity::strain)
        check_name(named, "strain gauge", gauges, gauge_fix, issues);
      else if (!known_points.contains(target))
        check_name(named, "point", points, "write points as substructure.name", issues);
    }
  }
}

void check_reported_names(const d::Case& given, const CoupledModel& model, IssueList& issues) {
  std::vector<std::string> meshes;
  for (const auto& [name, part] : given.substructures)
    if (part.finite_elements) meshes.push_back(name);
  if (given.predict)
    check_name(given.predict->substructure, "substructure", names_of(given.substructures), "name an existing one",
               issues);
  if (given.report.fields)
    check_name(given.report.fields->substructure, "finite-element substructure", meshes,
               "fields are written for meshes only: name a substructure with finite_elements", issues);
  for (const auto& name : given.report.displacements)
    check_name(name, "point", model.reported_points(), "name a point whose motion is reported: substructure.name",
               issues);
  for (const auto& name : given.report.strains) check_name(name, "strain gauge", model.gauges(), gauge_fix, issues);
}

namespace {

/// Refuses models that the integrators cannot step: a mass matrix without an entry on its diagonal, and too many
/// degrees of freedom for the full matrices of `exact`.
void check_integrator(const CaseStudy& study, IssueList& issues) {
  constexpr Eigen::Index most_exact = 5000;
  const auto& system = study.model->system();
  const Eigen::VectorXd mass = system.mass.diagonal();
  const Eigen::Index massless = (mass.array() <= 0.0).count();
  if (massless > 0) {
    Eigen::Index first = 0;
    mass.minCoeff(&first);
    issues.add(study.given.source.at({"simulate"}),
               std::to_string(massless) + " degrees of freedom have no mass; the first is '" +
                   system.dofs[static_cast<std::size_t>(first)] + "'",
               "time integration needs mass at every degree of freedom",
               "give them mass (`mass_matrix: consistent` beside a deck whose lumped beams have none at their "
               "rotations), or use "
               "reference: superelement");
  }
  if (study.given.simulate->integrator == Integrator::exact && system.size() > most_exact)
    issues.add(study.given.source.at({"simulate", "integrator"}),
               "simulate.integrator: exact given for " + std::to_string(system.size()) + " degrees of freedom",
               "its matrices are full, so at most " + std::to_string(most_exact),
               "use newmark or reference: superelement");
}

/// Takes one step from rest with models for which it costs nothing. Matrix entries of too different magnitude would
/// make the factorisation fail, and this step shows it before the run.
void check_first_step(const CaseStudy& study, IssueList& issues) {
  constexpr Eigen::Index most_dofs = 1000;
  const auto& system = study.model->system();
  if (system.size() > most_dofs) return;
  const auto& given = *study.given.simulate;
  SimulationOptions options;
  options.integrator = given.integrator;
  options.hht_alpha = given.hht_alpha;
  options.spectral_radius = given.spectral_radius;
  options.step = options.duration = 1.0 / (given.sample_rate * given.first_substeps);
  options.keep_motion = false;
  const std::vector<SignalPtr> still(static_cast<std::size_t>(system.input_count()), make_constant(0.0));
  try {
    simulate(system, still, at_rest(system.size(), system.connector_states()), options);
  } catch (const InvalidInput& error) {
    add_at(study.given.source.at({"simulate"}), error, issues);
  }
}

}  // namespace

void check_simulation(const CaseStudy& study, IssueList& issues) {
  if (!study.given.simulate) return;
  check_integrator(study, issues);
  if (issues.empty()) check_first_step(study, issues);
  const auto& given = *study.given.simulate;
  const auto place = [&](const char* key) { return study.given.source.at({"simulate", key}); };
  constexpr double most_samples = 1e8;
  const double samples = given.duration * given.sample_rate;
  if (samples < 1.0)
    issues.add(place("duration"),
               "simulate.duration: " + shortest(given.duration) + " s at " + shortest(given.sample_rate) +
                   " Hz is less than one sample",
               "the record would consist of its first sample only", "increase duration or sample_rate");
  if (samples > most_samples)
    issues.add(place("duration"),
               "simulate.duration: " + shortest(given.duration) + " s at " + shortest(given.sample_rate) + " Hz are " +
                   shortest(samples) + " samples",
               "at most " + shortest(most_samples) + " can be simulated", "reduce duration or sample_rate");
  if (given.max_substeps < given.first_substeps)
    issues.add(place("max_substeps"),
               "simulate.max_substeps: " + std::to_string(given.max_substeps) + " given with first_substeps of " +
                   std::to_string(given.first_substeps),
               "it must not be less", "increase it or reduce first_substeps");
  for (const auto& [point, start] : given.initial)
    if (study.model->dof_index(point) < 0)
      issues.add(
          start.location,
          start.path + ": '" + point + "' is not a degree of freedom" + did_you_mean(point, study.model->system().dofs),
          "", "name a degree of freedom of a lumped substructure");
}

void check_pictures(const CaseStudy& study, IssueList& issues) {
  const double zoom = study.given.report.zoom;
  if (!study.given.source.gives({"report", "zoom"})) return;
  if (study.sample_rate() > 0.0 && zoom * study.sample_rate() < 2.0)
    issues.add(study.given.source.at({"report", "zoom"}),
               "report.zoom: " + shortest(zoom) + " s at " + shortest(study.sample_rate()) + " Hz given",
               "the record has fewer than two samples", "lengthen it");
}

void check_signals(const CaseStudy& study, IssueList& issues) {
  double from = 0.0, to = 0.0;
  if (study.given.simulate) {
    const double finest = study.sample_rate() * study.given.simulate->first_substeps;
    to = std::ceil(study.given.simulate->duration * finest * (1.0 - 1e-12)) / finest;
  } else if (study.record) {
    from = study.record->record.start;
    to = study.record->record.end();
  } else {
    return;
  }
  for (std::size_t i = 0; i < study.structure->signals.size(); ++i) try {
      static_cast<void>(study.structure->signals[i]->sample(from, 1.0, 1));
      static_cast<void>(study.structure->signals[i]->sample(to, 1.0, 1));
    } catch (const InvalidInput& error) {
      const auto& input = study.structure->parts.inputs[i];
      for (const auto& issue : error.issues())
        issues.add(input.location, "excitation." + input.name + ": " + issue.what, issue.why, issue.fix);
    }
}

namespace {

/// A sensor that drives an interface must measure the acceleration of that very point.
void check_driving_sensor(const d::Case& given, const std::string& point, const Name& name, IssueList& issues) {
  const auto sensor = std::ranges::find(given.sensors, name.value, &std::pair<std::string, d::Sensor>::first);
  if (sensor == given.sensors.end()) {
    check_name(name, "sensor", names_of(given.sensors), "name one of the `sensors`", issues);
    return;
  }
  const std::string fix = "name an acceleration sensor at '" + point + "'";
  const auto* seen = std::get_if<d::Observed<ObservedQuantity::acceleration>>(&sensor->second.observed);
  if (!seen) {
    issues.add(name.location, name.path + ": sensor '" + name.value + "' does not measure acceleration",
               "an acceleration must drive the interface", fix);
    return;
  }
  const auto& points = seen->points.value;
  if (points == Named<double>{{point, 1.0}}) return;
  const std::string measured = points.size() == 1 ? "'" + points.front().first + "'" : "several points";
  issues.add(name.location, name.path + ": sensor '" + name.value + "' measures " + measured + ", not '" + point + "'",
             "the sensor must measure the interface point itself", fix);
}

void check_adaptive_noise(const d::Case& given, IssueList& issues) {
  const auto& estimate = *given.estimate;
  const auto& adaptive = estimate.adaptive_noise;
  if (!adaptive.any()) return;
  const auto at = given.source.at({"estimate", "adaptive_noise"});
  for (const auto& [name, unknown] : estimate.unknown) {
    const bool of_sensor = name.starts_with("sensors.") && name.ends_with(".noise");
    if (!(of_sensor && adaptive.sensors) && !(name == "process_noise" && adaptive.process)) continue;
    issues.add(
        unknown.initial.location,
        "estimate.unknown." + name + " is an unknown, and estimate.adaptive_noise." +
            (of_sensor ? "sensors" : "process") + " adapts it",
        "one number for the whole record by maximum likelihood and one that follows the record exclude each other",
        "remove one of them");
  }
  if (estimate.passes > 1)
    issues.add(given.source.at({"estimate", "passes"}), "estimate.passes is > 1 with estimate.adaptive_noise",
               "each pass would find the noise of every instant again from its stated value", "set passes: 1");
  if (given.update)
    issues.add(at, "estimate.adaptive_noise is given, but the case has `update`",
               "each step of the updating would judge the record by another noise",
               "find the noise in a run without `update`, then state it");
}

}  // namespace

void check_estimation(const d::Case& given, IssueList& issues) {
  if (!given.estimate) return;
  const auto& estimate = *given.estimate;
  check_adaptive_noise(given, issues);
  if (estimate.initial_state_from_record)
    for (const auto& [point, start] : estimate.initial_state)
      if (start.value.displacement != 0.0 || start.value.velocity != 0.0)
        issues.add(start.location, start.path + ": a mean is given together with initial_state_from_record",
                   "the record would replace this mean",
                   "remove the mean (standard deviations may stay) or initial_state_from_record");
  for (const auto& [name, sensor] : given.sensors)
    if (sensor.noise.value.value == 0.0)
      issues.add(sensor.noise.location, sensor.noise.path + ": the noise is 0",
                 "the filter needs the noise of every sensor", "give a small positive value");
  if (!estimate.local) return;
  for (const auto& [point, interface] : estimate.local->interface)
    if (const auto* driven = std::get_if<InterfaceAcceleration>(&interface.value.motion))
      check_driving_sensor(given, point, driven->sensor, issues);
}

void check_parameters_once(const d::Case& given, IssueList& issues) {
  std::map<std::string, std::string> refined;
  if (given.update)
    for (const auto& [name, parameter] : given.update->parameters)
      for (const auto& target : targets_of(name, parameter.value, parameter.location, parameter.path))
        refined.emplace(target.value, "update.parameters." + name);
  if (!given.estimate) return;
  std::map<std::string, std::string> estimated;
  for (const auto& [name, unknown] : given.estimate->unknown) {
    const std::string owner = "estimate.unknown." + name;
    for (const auto& target : targets_of(name, unknown, unknown.initial.location, owner)) {
      const auto [first, is_new] = estimated.emplace(target.value, owner);
      const auto update = refined.find(target.value);
      if (!is_new)
        issues.add(target.location, owner + ": '" + target.value + "' is estimated already by " + first->second,
                   "a parameter can have only one value", "remove one of them");
      if (update != refined.end())
        issues.add(target.location, owner + ": '" + target.value + "' is updated already by " + update->second,
                   "the updating and the filter would both change it", "remove one of them");
    }
  }
}

std::vector<std::string> unlike_filters(const description::Case& given) {
  std::vector<std::string> warnings;
  if (!given.record) return warnings;
  const auto& sensors = given.record->prepare;
  for (const auto& [name, excitation] : given.excitation) {
    const auto* file = excitation.signal_as<description::FileSignal>();
    if (file == nullptr) continue;
    for (const auto& [key, of_input, of_sensors] : {std::tuple("high_pass", file->prepare.high_pass, sensors.high_pass),
                                                    std::tuple("low_pass", file->prepare.low_pass, sensors.low_pass)})
      if (of_input != of_sensors)
        warnings.push_back("excitation '" + name + "' is measured: prepare." + key + " is " + shortest(of_input) +
                           " Hz there and " + shortest(of_sensors) + " Hz in record.prepare; filter both alike, or " +
                           "the model answers to motion that the sensors do not show");
  }
  return warnings;
}

}  // namespace kalfem
