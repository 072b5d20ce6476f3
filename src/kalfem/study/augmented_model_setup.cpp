#include "kalfem/study/augmented_model_setup.hpp"

#include <algorithm>

#include "kalfem/study/local_model.hpp"
#include "kalfem/study/parameter_lookup.hpp"
#include "kalfem/study/parameterised_structure.hpp"
#include "kalfem/study/unknown_builder.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
namespace d = description;

/// Index of "connector.state" among all internal states, -1 where there is none.
Index connector_state_index(const LocallyNonlinearSystem& system, const std::string& name) {
  Index index = 0;
  for (const auto& connector : system.connectors)
    for (const auto& state : connector.law->states()) {
      if (connector.name + "." + state.name == name) return index;
      ++index;
    }
  return -1;
}

/// Single degrees of freedom count more than `all`, in whatever order they stand.
void set_state_prior(const d::Estimation& given, const CoupledModel& model, StatePrior& prior, IssueList& issues) {
  const auto apply = [&](Index i, const d::PointPrior& start) {
    prior.mean.displacement[i] = start.displacement;
    prior.mean.velocity[i] = start.velocity;
    prior.displacement_deviation[i] = model.coordinate_scale()[i] * start.displacement_std;
    prior.velocity_deviation[i] = model.coordinate_scale()[i] * start.velocity_std;
  };
  for (const auto& [point, start] : given.initial_state)
    if (point == "all")
      for (Index i = 0; i < model.system().size(); ++i) apply(i, start.value);
  for (const auto& [point, start] : given.initial_state) {
    if (point == "all") continue;
    if (const Index index = model.dof_index(point); index >= 0)
      apply(index, start.value);
    else
      issues.add(start.location, start.path + ": '" + point + "' is no degree of freedom of the filter's model" +
                                     did_you_mean(point, model.system().dofs));
  }
  for (const auto& [name, start] : given.initial_connector_states) {
    const Index index = connector_state_index(model.system(), name);
    if (index < 0) {
      issues.add(start.location, start.path + ": there is no internal state '" + name + "'", "",
                 "write connector.state");
      continue;
    }
    prior.mean.connector_states[index] = start.value.value;
    prior.connector_state_deviation[index] = start.value.std;
  }
}

void set_noise(const d::Noise& given, const CoupledModel& model, ProcessNoise& noise, IssueList& issues) {
  noise.acceleration = given.acceleration * model.coordinate_scale();
  for (const auto& [point, density] : given.accelerations) {
    const Index index = model.dof_index(point);
    if (index < 0)
      issues.add(density.location, density.path + ": '" + point + "' is no degree of freedom of the filter's model" +
                                       did_you_mean(point, model.system().dofs));
    else
      noise.acceleration[index] = density.value;
  }
}

/// Sensors that the augmented model can see: on its own points, and not those that drive it.
std::vector<StudySensor> augmented_model_sensors(const Study& study, const AugmentedModelSetup& setup,
                                                 IssueList& issues) {
  std::vector<StudySensor> sensors;
  for (const auto& sensor : study.sensors) {
    const bool drives = std::ranges::find(setup.input_sources, "@" + sensor.name) != setup.input_sources.end();
    if (drives) continue;
    try {
      make_outputs(*setup.model, {sensor.output});
      sensors.push_back(sensor);
    } catch (const InvalidInput& error) {
      if (!study.given.estimate->local) issues.add(error, study.given.source.at({"sensors", sensor.name}));
    }
  }
  if (sensors.empty())
    issues.add(study.given.source.at({"sensors"}), "no sensor measures anything that the filter's model holds",
               "it would learn nothing", "place a sensor on the filter's model's part of the structure");
  return sensors;
}

void check_start_from_record(const Study& study, const AugmentedModelSetup& setup, IssueList& issues) {
  const auto measures_displacement = [](const StudySensor& sensor) {
    return sensor.output.quantity == ObservedQuantity::displacement;
  };
  if (std::ranges::none_of(setup.sensors, measures_displacement))
    issues.add(
        study.given.source.at({"estimate", "initial_state_from_record"}),
        "estimate.initial_state_from_record is given and no sensor of the filter's model measures a displacement",
        "the start is taken from displacement sensors", "remove it, or give the start under initial_state");
}

}  // namespace

PresentValues present_values(const UpdatingSetup& updating, const Eigen::VectorXd& values) {
  PresentValues present;
  for (const auto& [index, target] : updating.bindings) present[target.name] = values[index];
  return present;
}

namespace {

/// Leaves in `parts` what the augmented model holds, with the unknowns released from it.
void add_unknowns(const Study& study, const PresentValues& present, std::optional<LocalModel>& cut,
                  StructureParts& parts, AugmentedModelSetup& setup, IssueList& issues) {
  const auto& given = *study.given.estimate;
  if (given.local) {
    cut.emplace(*given.local, parts, issues);
    cut->apply(setup);
  } else {
    for (const auto& input : parts.inputs) {
      setup.input_sources.push_back(input.name);
      setup.options.inputs.push_back({});
    }
  }
  UnknownBuilder unknowns(study, present, parts, setup, issues);
  for (const auto& [name, unknown] : given.unknown) unknowns.add(name, unknown);
}

/// Rest positions that the record does not show: a constant in each sensor's channel, measured from where the record
/// was taken about.
void add_rest_positions(const Study& study, AugmentedModelSetup& setup) {
  if (!study.record || !study.record->free_response || !study.record->free_response->rest_is_unknown()) return;
  for (std::size_t i = 0; i < setup.sensors.size(); ++i) {
    const StudySensor& sensor = setup.sensors[i];
    UnknownParameter rest;
    rest.name = "rest." + sensor.name;
    rest.unit = sensor.unit;
    rest.deviation = study.record->free_response->deviation[study.record->series.find(sensor.name)];
    rest.sensors = {static_cast<Index>(i)};
    setup.options.unknowns.push_back(rest);
    setup.true_parameters.emplace_back();
  }
}

/// The structure at the first guesses of the linear unknowns in the place of the case's own.
StructureParts at_first_guesses(const Study& study, LinearUnknowns& unknowns,
                                const std::optional<VectorXd>& reduced_at) {
  const VectorXd initial = VectorXd::Map(unknowns.initial.data(), static_cast<Index>(unknowns.initial.size()));
  const ParameterisedStructure structure(study, unknowns.bindings, initial.size());
  unknowns.reduced_at = reduced_at.value_or(initial);
  unknowns.structure = std::make_shared<const StructureAtParameters>(structure.at(unknowns.reduced_at));
  return structure.near(*unknowns.structure, initial);
}

}  // namespace

StructureParts parts_at(const Study& study, const LinearUnknowns& unknowns, const VectorXd& values) {
  if (unknowns.bindings.empty()) return *unknowns.parts;
  return ParameterisedStructure(study, unknowns.bindings, values.size()).near(*unknowns.structure, values);
}

bool set_unknowns(const Study& study, const std::string& substructure, const VectorXd& values,
                  const PresentValues& refined, StructureParts& parts) {
  const auto counts = [&](const ParameterReference& reference) {
    return parts.damping || (reference.kind != ParameterReference::Kind::connector &&
                             parts.substructures[reference.part].name == substructure);
  };
  bool any = false;
  Index i = 0;
  for (const auto& [name, unknown] : study.given.estimate->unknown) {
    for (const auto& target : names_of(name, unknown)) {
      const auto reference = find_parameter(parts, target.value);
      if (!reference || !counts(*reference) || refined.contains(target.value))
        continue;  // those of finite elements are set with their matrices
      set_parameter(parts, *reference, values[i]);
      any = true;
    }
    ++i;
  }
  return any;
}

std::function<LocallyNonlinearSystem(const VectorXd&)> system_of_linear_unknowns(const Study& study,
                                                                                 const AugmentedModelSetup& setup) {
  if (setup.linear_unknowns.empty()) return {};
  return [&study, linear = setup.linear_unknowns](const VectorXd& values) {
    StructureParts parts = parts_at(study, linear, values);
    PresentValues present =
        linear.present;  // elements are released at these values: nothing is left to their connectors
    for (std::size_t i = 0; i < linear.names.size(); ++i) present[linear.names[i]] = values[static_cast<Index>(i)];
    IssueList issues;
    AugmentedModelSetup scratch;
    std::optional<LocalModel> cut;
    add_unknowns(study, present, cut, parts, scratch, issues);
    issues.raise();
    return couple(parts).system();
  };
}

AugmentedModelSetup make_augmented_model_setup(const Study& study, StructureParts parts, const PresentValues& present,
                                               IssueList& issues, const std::optional<VectorXd>& reduced_at) {
  const auto& given = *study.given.estimate;
  AugmentedModelSetup setup;
  std::optional<LocalModel> cut;
  auto given_parts = std::make_shared<const StructureParts>(parts);
  add_unknowns(study, present, cut, parts, setup, issues);
  if (!issues.empty()) return setup;
  if (!setup.linear_unknowns.empty()) {
    LinearUnknowns linear = std::move(setup.linear_unknowns);
    linear.present = present;
    linear.parts = std::move(given_parts);
    if (!linear.bindings.empty()) {
      parts = at_first_guesses(study, linear, reduced_at);
      setup = {};
      add_unknowns(study, present, cut, parts, setup, issues);
    }
    setup.linear_unknowns = std::move(linear);
  }

  setup.model = std::make_shared<const CoupledModel>(couple(parts));
  const auto& system = setup.model->system();
  constexpr Index most_dofs = 5000;
  if (system.size() > most_dofs) {
    issues.add(study.given.source.at({"estimate"}),
               "the filter would hold " + std::to_string(system.size()) + " degrees of freedom",
               "its covariance is a full matrix: at most " + std::to_string(most_dofs),
               "reduce the finite elements, or hold a part of the structure by estimate.local");
    return setup;
  }
  auto& options = setup.options;
  const VectorXd dofs = VectorXd::Zero(system.size()), inputs = VectorXd::Zero(system.input_count()),
                 states = VectorXd::Zero(system.connector_states());
  options.prior = {at_rest(system.size(), system.connector_states()), dofs, dofs, states, inputs, inputs, 0.0};
  options.process_noise = {dofs, inputs, states};
  set_state_prior(given, *setup.model, options.prior, issues);
  set_noise(given.process_noise, *setup.model, options.process_noise, issues);
  if (cut) cut->set_priors(setup);
  options.keep_initial_state = given.estimate_initial_state;
  options.step = 1.0 / study.sample_rate();
  options.substeps = given.substeps;
  setup.sensors = augmented_model_sensors(study, setup, issues);
  if (given.initial_state_from_record && issues.empty()) check_start_from_record(study, setup, issues);
  add_rest_positions(study, setup);
  return setup;
}

}  // namespace kalfem
