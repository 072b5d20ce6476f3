// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <type_traits>

#include "kalfem/base/random.hpp"
#include "kalfem/dynamics/simulate.hpp"
#include "kalfem/identification/filter_run.hpp"
#include "kalfem/identification/initial_state.hpp"
#include "kalfem/system/laws/law_library.hpp"
#include "kalfem/system/signals/random_signal.hpp"

/// The eleven-degree-of-freedom chain of Tsotalou et al. (2017), case 1, made of library types alone: a wheel on a
/// moving ground, a saturating suspension, and ten masses with 1 % modal damping.
namespace kalfem::test {

using StructureData = std::remove_const_t<StructurePtr::element_type>;

constexpr double wheel_stiffness = 2e4, body_stiffness = 3e4;  // [N/m]
constexpr double true_mu_k1 = 20.0, true_mu_c1 = 10.0;         // [N]
constexpr double chain_rate = 1000.0;                          // [Hz]

inline LumpedSubstructure chain_wheel() {
  LumpedSubstructure wheel;
  wheel.name = "wheel";
  wheel.masses = {{"w", 1.5}};
  wheel.springs = {{"k_w", "ground", "w", wheel_stiffness}};
  return wheel;
}

inline LumpedSubstructure chain_body() {
  LumpedSubstructure body;
  body.name = "body";
  body.grounds = {};
  for (int i = 1; i <= 10; ++i) {
    body.masses.push_back({std::to_string(i), 1.0});
    if (i == 1) continue;
    const auto below = std::to_string(i - 1), here = std::to_string(i);
    body.springs.push_back({below + "-" + here, below, here, body_stiffness});
  }
  body.modal_damping = {0.01};
  return body;
}

inline StructureParts chain_parts() {
  Eigen::VectorXd suspension(6);  // k, mu_k1, mu_k2, c, mu_c1, mu_c2
  suspension << 5e3, true_mu_k1, 2e-3, 10.0, true_mu_c1, 0.05;
  return {.substructures = {chain_wheel(), chain_body()},
          .finite_elements = {},
          .connectors = {{"suspension", "wheel.w", "body.1", make_law("saturating"), suspension}},
          .inputs = {{"road", InputKind::base_displacement, "wheel.ground"}}};
}

/// Roads of different names are different realisations of the same spectrum.
inline StructurePtr chain_structure(StructureParts parts = chain_parts(), const std::string& road = "random") {
  auto structure = std::make_shared<StructureData>();
  structure->parts = std::move(parts);
  structure->signals = {make_random(
      {.rms = 3e-3, .lower = 0.5, .upper = 30.0, .duration = 20.0, .fade_in = 0.5, .seed = 7, .name = road})};
  return structure;
}

inline Parameter parameter(const StructureData& structure, const std::string& name) {
  const auto found = ParameterSet(structure).find(name);
  if (!found) throw std::invalid_argument(name);
  return *found;
}

/// A sensor of the acceleration at a point; its noise is a part of the channel's rms.
inline Sensor accelerometer(const std::string& name, const std::string& point, double noise = 0.05) {
  return {.name = name,
          .output = {name, ObservedQuantity::acceleration, {{point, 1.0}}},
          .relative_noise = true,
          .noise = noise,
          .unit = "m/s^2"};
}

inline Unknown unknown(const StructureData& structure, const std::string& name, double initial, double deviation) {
  return {.name = name,
          .targets = {parameter(structure, name)},
          .transform = {TransformKind::log},
          .initial = initial,
          .deviation = deviation,
          .truth = parameter(structure, name).value};
}

/// The chain under four accelerometers, at degrees of freedom 3, 5, 7 and 11, with two unknowns of the suspension.
inline EstimationProblem chain_problem() {
  const auto structure = chain_structure();
  EstimationProblem problem{.structure = structure, .sample_rate = chain_rate};
  for (const std::string mass : {"2", "4", "6", "10"})
    problem.sensors.push_back(accelerometer("a" + mass, "body." + mass));
  problem.settings.unknowns = {unknown(*structure, "suspension.mu_k1", 10.0, 5.0),
                               unknown(*structure, "suspension.mu_c1", 16.0, 8.0)};
  problem.settings.initial_state = {{"all", {{0.0, 0.0, 1e-5, 1e-3}}}};
  problem.settings.threads = 1;
  return problem;
}

inline EstimationProblemPtr shared(EstimationProblem problem) {
  return std::make_shared<const EstimationProblem>(std::move(problem));
}

/// The whole structure's motion from a start, outputs at every sample.
inline SimulationResult simulate_chain(const StructureData& structure, const std::vector<OutputDescription>& outputs,
                                       double duration, const InitialMotion& start = {}) {
  const CoupledModel model = couple(structure.reference_parts());
  SimulationOptions options;
  options.step = 0.25 / chain_rate;
  options.keep_every = 4;
  options.duration = duration;
  options.every_sample = make_outputs(model, outputs);
  return simulate(model.system(), structure.signals, initial_state(start, model), options);
}

/// What the problem's sensors record of its own structure. Without noise in the samples their standard deviations are
/// the same.
inline Record chain_record(const EstimationProblem& problem, double duration, bool noisy = true) {
  std::vector<OutputDescription> outputs;
  for (const auto& sensor : problem.sensors) outputs.push_back(sensor.output);
  Record record;
  record.sample_rate = problem.sample_rate;
  record.values = simulate_chain(*problem.structure, outputs, duration).every_sample;
  for (std::size_t i = 0; i < problem.sensors.size(); ++i) {
    auto channel = record.values.row(static_cast<Eigen::Index>(i));
    const double noise = problem.sensors[i].deviation(rms(channel.transpose()));
    record.channels.push_back({problem.sensors[i].name, problem.sensors[i].unit, noise});
    RandomStream random(1, problem.sensors[i].name);
    for (double& sample : channel)
      if (noisy) sample += noise * random.normal();
  }
  return record;
}

inline EstimationResult run(const FilterRun& filter) {
  return estimate(*filter.choice.augmented_model, filter.input, {.filter = filter.choice.filter});
}

/// What an InvalidInput says; empty where nothing is thrown.
template <class Action>
std::string refusal(const Action& action) {
  try {
    action();
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

/// Everything that was found wrong, one a line.
inline std::string text_of(const IssueList& issues) {
  return refusal([&] { issues.raise(); });
}

}  // namespace kalfem::test
