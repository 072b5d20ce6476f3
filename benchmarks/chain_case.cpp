// SPDX-License-Identifier: Apache-2.0
#include "chain_case.hpp"

#include "kalfem/base/random.hpp"
#include "kalfem/dynamics/simulate.hpp"
#include "kalfem/model/lumped.hpp"
#include "kalfem/system/coupling.hpp"
#include "kalfem/system/laws/law_library.hpp"
#include "kalfem/system/signals/random_signal.hpp"

namespace kalfem::benchmarks {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double step = 1e-3;         // [s]
constexpr double noise_share = 0.15;  // rms of the noise over that of the signal
constexpr double mu_k1 = 20.0, mu_c1 = 10.0;

CoupledModel chain(Index upper_masses) {
  LumpedSubstructure wheel, body;
  wheel.name = "wheel";
  wheel.masses = {{"w", 1.5}};
  wheel.springs = {{"tyre", "ground", "w", 2e4, 0.0}};
  body.name = "body";
  body.modal_damping = {0.01};
  for (Index i = 1; i <= upper_masses; ++i) {
    body.masses.push_back({std::to_string(i), 1.0});
    if (i > 1) body.springs.push_back({"s" + std::to_string(i), std::to_string(i - 1), std::to_string(i), 3e4, 0.0});
  }
  const VectorXd parameters{{5e3, mu_k1, 2e-3, 10.0, mu_c1, 0.05}};
  return CoupledModel({{"wheel", assemble(wheel)}, {"body", assemble(body)}},
                      {{"suspension", "wheel.w", "body.1", saturating_law(), parameters}},
                      {{"road", InputKind::base_displacement, "wheel.ground"}});
}

/// Accelerations at masses 2, 4, 6 and 10 of ten, or as far along a longer chain.
OutputMap sensors(const CoupledModel& model, Index upper_masses) {
  std::vector<OutputDescription> descriptions;
  for (const Index tenth : {2, 4, 6, 10}) {
    const std::string mass = std::to_string(tenth * upper_masses / 10);
    descriptions.push_back({"a" + mass, ObservedQuantity::acceleration, {{"body." + mass, 1.0}}});
  }
  return make_outputs(model, descriptions);
}

UnknownParameter unknown(const std::string& name, Index parameter, double initial, double deviation) {
  UnknownParameter result;
  result.name = name;
  result.unit = "N";
  result.targets = {{0, parameter}};
  result.initial = initial;
  result.deviation = deviation;
  result.random_walk = 1e-3;
  return result;
}

AugmentedModelOptions augmented_model_options(Index dofs, StateCoordinates coordinates) {
  AugmentedModelOptions options;
  options.coordinates = coordinates;
  options.step = step;
  options.unknowns = {unknown("mu_k1", 1, 0.8 * mu_k1, 0.15 * mu_k1), unknown("mu_c1", 4, 1.2 * mu_c1, 0.15 * mu_c1)};
  options.process_noise = {VectorXd::Constant(dofs, 1e-2), VectorXd::Zero(1), VectorXd()};
  options.prior = {.mean = {VectorXd::Zero(dofs), VectorXd::Zero(dofs), VectorXd()},
                   .displacement_deviation = VectorXd::Constant(dofs, 1e-4),
                   .velocity_deviation = VectorXd::Constant(dofs, 1e-3),
                   .connector_state_deviation = VectorXd(),
                   .input_deviation = VectorXd::Zero(1),
                   .input_rate_deviation = VectorXd::Zero(1)};
  return options;
}

/// Sensor signals of a simulated motion with their noise, and its covariance R.
FilterInput record(const OutputMap& outputs, const SimulationResult& result) {
  const auto& motion = result.trajectory;
  FilterInput record;
  record.inputs = motion.inputs;
  record.measured.values = outputs.displacement * motion.displacement + outputs.velocity * motion.velocity +
                           outputs.acceleration * motion.acceleration + outputs.force * motion.force;
  const VectorXd deviation =
      noise_share * record.measured.values.rowwise().norm() / std::sqrt(static_cast<double>(record.measured.samples()));
  record.noise = deviation.cwiseAbs2().asDiagonal();
  RandomStream random(7, "noise");
  for (Index k = 0; k < record.measured.samples(); ++k)
    for (Index i = 0; i < record.measured.values.rows(); ++i)
      record.measured.values(i, k) += deviation[i] * random.normal();
  return record;
}

}  // namespace

ChainCase chain_case(Index states, Index samples) {
  const Index dofs = states / 2 - 1, upper_masses = dofs - 1;
  const CoupledModel model = chain(upper_masses);
  const OutputMap outputs = sensors(model, upper_masses);
  const auto road = make_random({.rms = 3e-3, .lower = 0.5, .upper = 30.0, .duration = 20.0, .seed = 7});
  const InitialState rest{VectorXd::Zero(dofs), VectorXd::Zero(dofs), VectorXd()};
  const auto result =
      simulate(model.system(), {road}, rest, {.step = step, .duration = static_cast<double>(samples - 1) * step});
  const auto augmented_model = [&](StateCoordinates coordinates) {
    return std::make_unique<AugmentedModel>(model.system(), outputs, std::vector<MeasurementChain>{},
                                            augmented_model_options(dofs, coordinates));
  };
  return {augmented_model(StateCoordinates::physical), augmented_model(StateCoordinates::modal),
          record(outputs, result)};
}

}  // namespace kalfem::benchmarks
