// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/augmented_model_setup.hpp"

#include <algorithm>

#include "kalfem/base/units.hpp"
#include "kalfem/identification/local_model.hpp"
#include "kalfem/identification/released_elements.hpp"
#include "kalfem/identification/unknown_inputs.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Index of "connector.state" among all internal states; -1 if there is none.
Index connector_state_index(const LocallyNonlinearSystem& system, const std::string& name) {
  Index index = 0;
  for (const auto& connector : system.connectors)
    for (const auto& state : connector.law->states()) {
      if (connector.name + "." + state.name == name) return index;
      ++index;
    }
  return -1;
}

/// Entries of single degrees of freedom override `all`, in any order.
void set_state_prior(const EstimationSettings& given, const CoupledModel& model, StatePrior& prior, IssueList& issues) {
  const auto apply = [&](Index i, const PointPrior& start) {
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
      issues.add(start.location, start.path + ": '" + point + "' is not a degree of freedom of the filter's model" +
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

void set_noise(const AccelerationNoise& given, const CoupledModel& model, ProcessNoise& noise, IssueList& issues) {
  noise.acceleration = given.acceleration * model.coordinate_scale();
  for (const auto& [point, density] : given.accelerations) {
    const Index index = model.dof_index(point);
    if (index < 0)
      issues.add(density.location, density.path + ": '" + point + "' is not a degree of freedom of the filter's model" +
                                       did_you_mean(point, model.system().dofs));
    else
      noise.acceleration[index] = density.value;
  }
}

/// Sensors at points of the filter's model, without those that drive it.
std::vector<Sensor> sensors_of(const EstimationProblem& problem, const AugmentedModelSetup& setup, IssueList& issues) {
  std::vector<Sensor> sensors;
  for (const auto& sensor : problem.sensors) {
    const bool drives = std::ranges::find(setup.input_sources, "@" + sensor.name) != setup.input_sources.end();
    if (drives) continue;
    try {
      make_outputs(*setup.model, {sensor.output});
      sensors.push_back(sensor);
    } catch (const InvalidInput& error) {
      if (!problem.settings.local) issues.add(error, sensor.location);
    }
  }
  if (sensors.empty())
    issues.add(problem.sensors.empty() ? SourceLocation{} : problem.sensors.front().location,
               "no sensor is attached to the modelled part", "there is nothing to estimate from",
               "attach a sensor to a part of the structure that the filter's model contains");
  return sensors;
}

void add_offsets(const EstimationProblem& problem, AugmentedModelSetup& setup) {
  for (const auto& offset : problem.offsets) {
    const auto sensor = std::ranges::find(setup.sensors, offset.sensor, &Sensor::name);
    if (sensor == setup.sensors.end()) continue;
    setup.options.unknowns.push_back({.name = offset.name,
                                      .unit = sensor->unit,
                                      .targets = {},
                                      .transform = {},
                                      .initial = offset.initial,
                                      .deviation = offset.deviation,
                                      .random_walk = offset.random_walk,
                                      .sensors = {sensor - setup.sensors.begin()}});
    setup.true_parameters.push_back(offset.truth);
  }
}

/// Adds unknowns to a setup and releases the elements among them from its parts.
class UnknownBuilder {
public:
  UnknownBuilder(const EstimationProblem& problem, const PresentValues& present, StructureParts& parts,
                 AugmentedModelSetup& setup, IssueList& issues)
      : whole_(problem.structure->parts), present_(present), parts_(parts), setup_(setup), issues_(issues) {}

  void add(const Unknown& given) {
    UnknownParameter unknown{given.name,      given.unit(),     {}, given.transform, given.initial,
                             given.deviation, given.random_walk};
    if (const auto value = present_.find(given.name); value != present_.end()) unknown.initial = value->second;
    const bool released = can_be_released(whole_, given.targets.front());
    if (released) {
      unknown.in_linear_part =
          std::ranges::any_of(given.targets, [&](const auto& target) { return linear_part_follows(whole_, target); });
      if (unknown.in_linear_part && !check_positive(given, unknown)) return;
      for (const auto& target : given.targets) unknown.targets.push_back(release(parts_, target, unknown.initial));
    }
    if (!released || unknown.in_linear_part) add_linear(given, unknown, released);
    setup_.options.unknowns.push_back(unknown);
    setup_.true_parameters.push_back(given.truth);
  }

private:
  bool check_positive(const Unknown& given, const UnknownParameter& unknown) {
    if (unknown.initial > 0.0 || !std::ranges::all_of(given.targets, is_positive_by_nature)) return true;
    issues_.add(given.location, "'" + given.name + "' starts at " + shortest(unknown.initial) + " " + unknown.unit,
                "the modal damping of its substructure depends on it, so it must be positive",
                "start from a positive initial value");
    return false;
  }

  /// Records that the linear part depends on the unknown, and its bindings if no connector carries it.
  void add_linear(const Unknown& given, const UnknownParameter& unknown, bool released) {
    auto& linear = setup_.linear_unknowns;
    linear.names.push_back(unknown.name);
    linear.initial.push_back(unknown.initial);
    if (released) return;
    for (const auto& target : given.targets)
      linear.bindings.push_back({static_cast<Index>(linear.names.size()) - 1, target});
  }

  const StructureParts& whole_;
  const PresentValues& present_;
  StructureParts& parts_;
  AugmentedModelSetup& setup_;
  IssueList& issues_;
};

/// Reduces `parts` to those of the filter's model, and releases the unknowns from them.
void add_unknowns(const EstimationProblem& problem, const PresentValues& present, std::optional<LocalModel>& local,
                  StructureParts& parts, AugmentedModelSetup& setup, IssueList& issues) {
  if (problem.settings.local) {
    local.emplace(*problem.settings.local, parts, issues);
    local->apply(setup);
  } else {
    for (const auto& input : parts.inputs) {
      setup.input_sources.push_back(input.name);
      setup.options.inputs.push_back({});
    }
  }
  treat_as_unknown(problem.settings.unknown_inputs, setup);
  UnknownBuilder unknowns(problem, present, parts, setup, issues);
  for (const auto& unknown : problem.settings.unknowns) unknowns.add(unknown);
}

/// The linear substructures over the values of the linear unknowns, and behind these of what is held.
ParameterisedStructure over_all(const EstimationProblem& problem, const LinearUnknowns& unknowns) {
  auto bindings = unknowns.bindings;
  auto index = static_cast<Index>(unknowns.names.size());
  for (const auto& parameter : unknowns.held.parameters) bindings.push_back({index++, parameter});
  return ParameterisedStructure(problem.structure, bindings, index);
}

VectorXd with_held(const LinearUnknowns& unknowns, const VectorXd& values) {
  VectorXd all(values.size() + unknowns.held.values.size());
  all << values, unknowns.held.values;
  return all;
}

/// The structure at the initial values of the linear unknowns, in place of the given one.
StructureParts at_first_guesses(const EstimationProblem& problem, LinearUnknowns& unknowns,
                                const std::optional<VectorXd>& reduced_at) {
  const VectorXd initial = VectorXd::Map(unknowns.initial.data(), static_cast<Index>(unknowns.initial.size()));
  const ParameterisedStructure structure = over_all(problem, unknowns);
  unknowns.reduced_at = reduced_at.value_or(initial);
  unknowns.structure =
      unknowns.held.structure
          ? unknowns.held.structure
          : std::make_shared<const StructureAtParameters>(structure.at(with_held(unknowns, unknowns.reduced_at)));
  return structure.near(*unknowns.structure, with_held(unknowns, initial));
}

/// Prior and noise of a structure at rest; the settings fill in their values.
void set_zero_prior(const LocallyNonlinearSystem& system, AugmentedModelOptions& options) {
  const VectorXd dofs = VectorXd::Zero(system.size()), inputs = VectorXd::Zero(system.input_count()),
                 states = VectorXd::Zero(system.connector_states());
  options.prior = {at_rest(system.size(), system.connector_states()), dofs, dofs, states, inputs, inputs, 0.0};
  options.process_noise = {dofs, inputs, states};
}

}  // namespace

Index SubstepChoice::largest() const {
  Index unknown = -1;
  if (bias.size() > 0) bias.maxCoeff(&unknown);
  return unknown;
}

StructureParts parts_at(const EstimationProblem& problem, const LinearUnknowns& unknowns, const VectorXd& values) {
  if (unknowns.bindings.empty()) return *unknowns.parts;
  return over_all(problem, unknowns).near(*unknowns.structure, with_held(unknowns, values));
}

bool set_unknowns(const EstimationProblem& problem, const std::string& substructure, const VectorXd& values,
                  const PresentValues& refined, StructureParts& parts) {
  bool any = false;
  const auto& unknowns = problem.settings.unknowns;
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    for (const auto& target : unknowns[i].targets) {
      const bool counts = parts.damping || target.owner == substructure;
      const bool here = can_be_released(problem.structure->parts, target);  // others are set with their matrices
      if (!counts || !here || refined.contains(target.name)) continue;
      any = set_parameter(parts, target, values[static_cast<Index>(i)]) || any;
    }
  return any;
}

std::function<LocallyNonlinearSystem(const VectorXd&)> system_of_linear_unknowns(const EstimationProblemPtr& problem,
                                                                                 const AugmentedModelSetup& setup) {
  if (setup.linear_unknowns.empty()) return {};
  return [problem, linear = setup.linear_unknowns](const VectorXd& values) {
    StructureParts parts = parts_at(*problem, linear, values);
    PresentValues present =
        linear.present;  // elements are released at these values: nothing is left to their connectors
    for (std::size_t i = 0; i < linear.names.size(); ++i) present[linear.names[i]] = values[static_cast<Index>(i)];
    IssueList issues;
    AugmentedModelSetup scratch;
    std::optional<LocalModel> local;
    add_unknowns(*problem, present, local, parts, scratch, issues);
    issues.raise();
    return couple(parts).system();
  };
}

// 1. Cut out the local part, if requested, and release the unknowns into connectors.
// 2. If the linear part depends on unknowns without a connector, evaluate the parts at their initial values and release
//    again from the new parts.
// 3. Couple the parts, and set prior and process noise by degree of freedom.
// 4. Select the sensors of the model. Each offset becomes an unknown that adds to its sensor.
AugmentedModelSetup make_augmented_model_setup(const EstimationProblem& problem, StructureParts parts,
                                               const PresentValues& present, IssueList& issues,
                                               const std::optional<VectorXd>& reduced_at, const HeldElements& held) {
  const EstimationSettings& settings = problem.settings;
  AugmentedModelSetup setup;
  std::optional<LocalModel> local;
  auto given_parts = std::make_shared<const StructureParts>(parts);
  add_unknowns(problem, present, local, parts, setup, issues);
  if (!issues.empty()) return setup;
  if (!setup.linear_unknowns.empty()) {
    LinearUnknowns linear = std::move(setup.linear_unknowns);
    linear.present = present;
    linear.parts = given_parts;
    linear.held = held;
    if (!linear.bindings.empty()) {
      parts = at_first_guesses(problem, linear, reduced_at);
      setup = {};
      add_unknowns(problem, present, local, parts, setup, issues);
    }
    setup.linear_unknowns = std::move(linear);
  }

  setup.parts = std::move(given_parts);
  setup.model = std::make_shared<const CoupledModel>(couple(parts));
  constexpr Index most_dofs = 5000;
  if (const Index dofs = setup.model->system().size(); dofs > most_dofs) {
    issues.add({}, "the filter's model would have " + std::to_string(dofs) + " degrees of freedom",
               "its covariance is a full matrix, so at most " + std::to_string(most_dofs),
               "reduce the finite elements, or model only a part of the structure by estimate.local");
    return setup;
  }
  auto& options = setup.options;
  set_zero_prior(setup.model->system(), options);
  set_state_prior(settings, *setup.model, options.prior, issues);
  set_noise(settings.process_noise, *setup.model, options.process_noise, issues);
  options.process_noise.unit_acceleration = setup.model->coordinate_scale();
  if (local) local->set_priors(setup);
  set_noise_of_unknown_inputs(settings.unknown_inputs, setup);
  options.keep_initial_state = settings.estimate_initial_state;
  options.step = 1.0 / problem.sample_rate;
  options.substeps = settings.substeps.value_or(SubstepChoice{}.substeps);
  options.step_order = settings.step_order;
  setup.sensors = sensors_of(problem, setup, issues);
  add_offsets(problem, setup);
  return setup;
}

}  // namespace kalfem
