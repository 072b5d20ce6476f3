// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/filter_problem.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/api/structure_description.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/identification/fixed_numbers.hpp"
#include "kalfem/identification/measurement_unknowns.hpp"
#include "kalfem/identification/released_elements.hpp"

namespace kalfem {
namespace {

/// "unknowns[0] 'suspension.mu_k1'": an argument by its place; "unknowns[0].std 'suspension.mu_k1'": a member of it.
std::string place_of(const char* list, std::size_t index, const std::string& name, const std::string& member = "") {
  return std::string(list) + "[" + std::to_string(index) + "]" + (member.empty() ? "" : "." + member) + " '" + name +
         "'";
}

/// Adds the issues of an error, each with the place of its argument.
void add(const InvalidInput& error, const std::string& place, IssueList& issues) {
  for (const auto& issue : error.issues()) issues.add({}, place + ": " + issue.what, issue.why, issue.fix);
}

template <class T>
void refuse_doubles(const char* list, const std::vector<T>& all, IssueList& issues) {
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (all[i].name == all[j].name)
        issues.add({}, place_of(list, i, all[i].name) + ": " + list + "[" + std::to_string(j) + "] has that name too",
                   "names tell them apart", "give each its own");
}

/// Frequency above which no sensor responds [Hz].
double bandwidth_of(const std::vector<SensorDescription>& sensors, double sample_rate) {
  double widest = 0.0;
  for (const auto& sensor : sensors) widest = std::max(widest, std::min(0.5 * sample_rate, bandwidth(sensor.chain)));
  return widest > 0.0 ? widest : std::numeric_limits<double>::infinity();
}

std::vector<std::string> targets_of(const UnknownDescription& given) {
  return given.prior.applies_to.empty() ? std::vector{given.name} : given.prior.applies_to;
}

ParameterTransform transform_of(const Prior& prior, const StructureParts& parts, const Unknown& unknown) {
  if (prior.transform) return *prior.transform;
  const bool is_released = can_be_released(parts, unknown.targets.front());
  const bool is_positive = std::ranges::all_of(unknown.targets, is_positive_by_nature);
  const bool stays_positive = unknown.initial > 0.0 && (!is_released || is_positive);
  return {stays_positive ? TransformKind::log : TransformKind::none};
}

/// `index`: of the unknown among the options.
void check_numbers(const Unknown& unknown, std::size_t index, IssueList& issues) {
  const auto refuse = [&](const char* member, const std::string& what, const char* why, const char* fix) {
    issues.add({}, place_of("unknowns", index, unknown.name, member) + ": it is " + what, why, fix);
  };
  const auto& [kind, lower, upper] = unknown.transform;
  const std::string value = shortest(unknown.initial);
  if (!std::isfinite(unknown.initial)) refuse("initial", value, "a number is needed", "give a finite initial value");
  if (!(unknown.deviation > 0.0) || !std::isfinite(unknown.deviation))
    refuse("std", shortest(unknown.deviation), "a parameter without uncertainty is not unknown", "give a positive std");
  if (!(unknown.random_walk >= 0.0) || !std::isfinite(unknown.random_walk))
    refuse("random_walk", shortest(unknown.random_walk), "it must be >= 0", "");
  if (kind == TransformKind::log && !(unknown.initial > 0.0))
    refuse("initial", value, "under the transform log it must be > 0", "start from a positive value");
  if (kind == TransformKind::logit && !(lower < unknown.initial && unknown.initial < upper))
    refuse("initial", value + ", outside its bounds " + shortest(lower) + " to " + shortest(upper),
           "the start must lie strictly between them", "move the start or the bounds");
}

Unknown unknown_of(const UnknownDescription& given, const ParameterSet& all, const StructureParts& parts) {
  Unknown unknown{.name = given.name, .targets = {}};
  for (const auto& name : targets_of(given)) {
    auto parameter = all.find(name);
    if (!parameter)
      throw InvalidInput("there is no parameter '" + name + "'" + did_you_mean(name, all.names()),
                         "an unknown is a number of a connector or of a substructure",
                         "Structure::parameters() lists them");
    unknown.targets.push_back(std::move(*parameter));
  }
  unknown.initial = given.prior.initial.value_or(unknown.targets.front().value);
  unknown.deviation = given.prior.std != 0.0 ? given.prior.std : 0.5 * std::abs(unknown.initial);
  unknown.random_walk = given.prior.random_walk;
  unknown.transform = transform_of(given.prior, parts, unknown);
  return unknown;
}

/// An unknown of the measurement, whose sensor must be one of the problem's.
void add_of_measurement(const UnknownDescription& given, EstimationProblem& problem) {
  const auto& [name, prior] = given;
  std::vector<std::string> known;
  for (const auto& each : problem.sensors) known.push_back(each.name);
  for (const auto& sensor : measured_sensors(name, prior.applies_to))
    if (std::ranges::find(known, sensor) == known.end())
      throw InvalidInput("there is no sensor '" + sensor + "'" + did_you_mean(sensor, known), "",
                         "name one of `sensors`");
  if (!prior.initial)
    throw InvalidInput("it has no initial value", "the structure has no number of that name", "give one");
  if (prior.transform || (prior.random_walk != 0.0 && is_found_by_likelihood(name)))
    throw InvalidInput("it has a transform or a random walk",
                       "a number of the measurement is one for the record; an offset alone may drift",
                       "leave them out");
  const auto deviation = prior.std != 0.0 ? std::optional(prior.std) : std::nullopt;
  add_measurement_unknown(name,
                          {.initial = *prior.initial,
                           .deviation = deviation,
                           .random_walk = prior.random_walk,
                           .applies_to = prior.applies_to},
                          problem);
}

Sensor sensor_of(const SensorDescription& given, const CoupledModel& model) {
  Sensor sensor{.name = given.name, .output = given.output, .chain = MeasurementChain(given.chain)};
  sensor.output.name = given.name;
  sensor.noise = given.noise;
  sensor.unit = unit_of(given.output);
  make_outputs(model, {sensor.output});  // throws if there is no such point
  return sensor;
}

/// Displacement and velocity of every reported point, and the strain of every gauge.
std::vector<OutputDescription> motions_of(const CoupledModel& model) {
  std::vector<OutputDescription> outputs;
  for (const auto& point : model.reported_points()) {
    outputs.push_back({point + ".displacement", ObservedQuantity::displacement, {{point, 1.0}}});
    outputs.push_back({point + ".velocity", ObservedQuantity::velocity, {{point, 1.0}}});
  }
  for (const auto& gauge : model.gauges())
    outputs.push_back({gauge + ".strain", ObservedQuantity::strain, {{gauge, 1.0}}});
  return outputs;
}

/// Makes a problem from the caller's options: structure, sensors, unknowns, then settings. Checks each argument
/// separately and raises all issues together, each with its place in the options.
class ProblemMaker {
public:
  ProblemMaker(const Structure& structure, double sample_rate, const EstimateOptions& options) : options_(options) {
    problem_.sample_rate = sample_rate;
    problem_.structure = make_structure_model(
        structure.description(),
        {.parameters = varied_names(), .sensor_bandwidth = bandwidth_of(options.sensors, sample_rate)});
  }

  FilterProblem make() {
    if (options_.sensors.empty())
      issues_.add({}, "sensors: the list is empty", "there is nothing to estimate from", "give at least one sensor");
    if (const auto thoughts = options_.second_thoughts; thoughts && !(*thoughts >= 0.0))
      issues_.add({}, "second_thoughts: it is " + shortest(*thoughts), "filter steps cannot be negative",
                  "give 0 for none, or so many times those of the first answer");
    refuse_doubles("sensors", options_.sensors, issues_);
    refuse_doubles("unknowns", options_.unknowns, issues_);
    add_sensors();
    add_unknowns();
    issues_.raise();
    add_settings();
    return finished();
  }

private:
  [[nodiscard]] std::vector<std::string> varied_names() const {
    std::vector<std::string> names;
    for (const auto& unknown : options_.unknowns)
      for (const auto& name : targets_of(unknown)) names.push_back(name);
    for (const auto& stated : options_.known_to) names.push_back(stated.name);
    return names;
  }

  void add_sensors() {
    const CoupledModel model = couple(problem_.structure->parts);
    for (std::size_t i = 0; i < options_.sensors.size(); ++i) try {
        const auto& given = options_.sensors[i];
        if (!(given.noise > 0.0) || !std::isfinite(given.noise))
          issues_.add({}, place_of("sensors", i, given.name, "noise") + ": it is " + shortest(given.noise),
                      "a filter weighs a sensor by its noise", "give the standard deviation of its noise, > 0");
        problem_.sensors.push_back(sensor_of(given, model));
      } catch (const InvalidInput& error) {
        add(error, place_of("sensors", i, options_.sensors[i].name), issues_);
      }
    for (std::size_t i = 0; i < options_.outputs.size(); ++i) try {
        make_outputs(model, {options_.outputs[i].output});
      } catch (const InvalidInput& error) {
        add(error, place_of("outputs", i, options_.outputs[i].name), issues_);
      }
  }

  void add_unknowns() {
    const ParameterSet all(*problem_.structure);
    for (std::size_t i = 0; i < options_.unknowns.size(); ++i) try {
        const auto& given = options_.unknowns[i];
        if (is_measurement_unknown(given.name)) {
          add_of_measurement(given, problem_);
          continue;
        }
        problem_.settings.unknowns.push_back(unknown_of(given, all, problem_.structure->parts));
        check_numbers(problem_.settings.unknowns.back(), i, issues_);
      } catch (const InvalidInput& error) {
        add(error, place_of("unknowns", i, options_.unknowns[i].name), issues_);
      }
  }

  void add_settings() {
    auto& settings = problem_.settings;
    settings.filter = options_.filter;
    settings.initial_state_from_record = options_.initial_state_from_record;
    settings.process_noise.acceleration = options_.process_noise;
    const auto& [sensors, process, memory] = options_.adaptive_noise;
    settings.adaptive_noise = {sensors, process, memory};
    settings.estimate_initial_state = options_.estimate_initial_state;
    settings.passes = options_.passes;
    settings.settle = options_.settle;
    settings.diagnose = options_.diagnose;
    settings.second_thoughts = options_.second_thoughts.value_or(options_.diagnose ? StepBudget::unlimited : 0.0);
    settings.substeps = options_.substeps;
    settings.step_order = options_.step_order;
    settings.threads = options_.threads;
    settings.known_to = options_.known_to;
    settings.free = options_.free;
    for (std::size_t i = 0; i < options_.initial_state.size(); ++i) {
      const auto& [point, prior] = options_.initial_state[i];
      settings.initial_state.push_back({point, {prior, {}, "initial_state[" + std::to_string(i) + "]"}});
    }
    for (std::size_t i = 0; i < options_.initial_connector_states.size(); ++i) {
      const auto& [state, prior] = options_.initial_connector_states[i];
      settings.initial_connector_states.push_back(
          {state, {prior, {}, "initial_connector_states[" + std::to_string(i) + "]"}});
    }
  }

  FilterProblem finished() {
    FilterProblem made;
    made.problem = std::make_shared<const EstimationProblem>(std::move(problem_));
    made.setup = make_augmented_model_setup(*made.problem, made.problem->structure->parts, {}, issues_);
    issues_.raise();
    check_known_to(*made.problem, made.problem->structure->parts, made.setup, issues_);
    issues_.raise();
    made.monitored = motions_of(*made.setup.model);
    for (const auto& [name, output] : options_.outputs) {
      made.monitored.push_back(output);
      made.monitored.back().name = name;
    }
    return made;
  }

  const EstimateOptions& options_;
  EstimationProblem problem_;
  IssueList issues_;
};

}  // namespace

void refuse_measurement_unknowns(const std::vector<UnknownDescription>& unknowns, IssueList& issues) {
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    if (is_measurement_unknown(unknowns[i].name))
      issues.add({}, place_of("unknowns", i, unknowns[i].name) + ": a number of the measurement is unknown",
                 "only estimate() finds one, from a whole record", "estimate it first, then state it with its sensor");
}

std::string unit_of(const OutputDescription& output) { return unit_of(output.quantity); }

FilterProblem make_filter_problem(const Structure& structure, double sample_rate, const EstimateOptions& options) {
  if (!(sample_rate > 0.0) || !std::isfinite(sample_rate))
    throw InvalidInput("the sampling rate is " + shortest(sample_rate) + " Hz", "it must be > 0",
                       "give the record's rate");
  if (options.substeps && *options.substeps < 1)
    throw InvalidInput("substeps: " + std::to_string(*options.substeps), "a sample interval has at least one", "");
  if (options.step_order != 2 && options.step_order != 4)
    throw InvalidInput("step_order: " + std::to_string(options.step_order), "the filter has steps of order 2 and 4",
                       "use 2 or 4");
  return ProblemMaker(structure, sample_rate, options).make();
}

}  // namespace kalfem
