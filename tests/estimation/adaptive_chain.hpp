// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estimation/chain_model.hpp"

namespace kalfem {

/// The chain over 20 s, with or without forces on its body that the filter's model leaves out.
struct AdaptiveChain {
  /// Of the forces that are left out, as process noise [m/s^2/sqrt(Hz)].
  static constexpr double density = 0.1;
  static constexpr double duration = 20.0;

  double rate = Chain::rate;  ///< of the record [Hz]
  Chain chain;
  ConvergedSolution undisturbed = chain.reference(duration, rate);
  ConvergedSolution disturbed = with_forces();

  explicit AdaptiveChain(double sample_rate = Chain::rate) : rate(sample_rate) {}

  /// White up to 300 Hz on every mass of the body.
  [[nodiscard]] ConvergedSolution with_forces() const {
    LumpedSubstructure wheel, body;
    wheel.masses = {{"w", 1.5}};
    wheel.springs = {{"tyre", "ground", "w", 2e4}};
    std::vector<InputDescription> inputs{{"road", InputKind::base_displacement, "wheel.ground"}};
    std::vector<SignalPtr> signals{chain.road};
    constexpr double band = 300.0;
    for (int i = 1; i <= 10; ++i) {
      const std::string mass = std::to_string(i);
      body.masses.push_back({mass, 1.0});
      if (i > 1) body.springs.push_back({"s" + mass, std::to_string(i - 1), mass, chain.body_stiffness});
      inputs.push_back({"f" + mass, InputKind::force, "body." + mass});
      signals.push_back(make_random({.rms = density * std::sqrt(2.0 * band),
                                     .lower = 0.05,
                                     .upper = band,
                                     .duration = duration,
                                     .seed = 9,
                                     .name = "force " + mass}));
    }
    body.modal_damping = {0.01};
    const auto parameters = values({5e3, Chain::mu_k1, 2e-3, 10.0, Chain::mu_c1, 0.05});
    const CoupledModel model({{"wheel", assemble(wheel)}, {"body", assemble(body)}},
                             {{"suspension", "wheel.w", "body.1", make_law("saturating"), parameters}}, inputs);
    return simulate_converged(model.system(), signals, at_rest(11, 0),
                              make_outputs(model, {Chain::acceleration("2"), Chain::acceleration("4"),
                                                   Chain::acceleration("6"), Chain::acceleration("10")}),
                              {}, {.integrator = Integrator::newmark, .duration = duration},
                              {.sample_rate = rate, .max_substeps = 64, .tolerance = 2e-3});
  }

  /// The record with true noise as R, as the filter's model sees its inputs.
  [[nodiscard]] FilterInput record(const ConvergedSolution& reference, std::uint64_t seed) const {
    auto record = Chain::record(reference, seed);
    record.inputs = chain.inputs(4.0 * rate, 4 * (reference.sensors.cols() - 1) + 1);
    return record;
  }

  [[nodiscard]] EstimationResult run(const FilterInput& input, const AdaptiveNoiseOptions& adaptive,
                                     double process_noise, FilterKind filter = FilterKind::partially_linear) const {
    auto options = chain.options(TransformKind::log, rate);
    options.substeps = 4;
    options.process_noise.acceleration.setConstant(process_noise);
    if (filter == FilterKind::partially_linear) options.coordinates = StateCoordinates::modal;
    const AugmentedModel model(chain.model.system(), chain.sensors, {}, options);
    return estimate(model, input,
                    {.filter = filter, .state_deviations = false, .keep_unknowns = true, .adaptive_noise = adaptive});
  }
};

/// Mean NIS over its expectation in the second half of the record.
inline double relative_nis(const EstimationResult& result) {
  const Eigen::Index half = result.nis.size() / 2;
  return result.nis.tail(half).sum() / static_cast<double>(result.measured.tail(half).sum());
}

/// The larger of the unknowns' errors over the larger of their two deviations, in the filter's state.
inline double worst_error(const EstimationResult& result) {
  const auto robust = robust_covariance(result.unknowns_history).covariance;
  const Eigen::Index last = result.unknowns.mean.cols() - 1;
  const double truth[] = {Chain::mu_k1, Chain::mu_c1};
  double worst = 0.0;
  for (const Eigen::Index i : {0, 1}) {
    const double error = std::log(result.unknowns.mean(i, last) / truth[i]);
    const double plain = result.unknowns.deviation(i, last) / result.unknowns.mean(i, last);
    worst = std::max(worst, std::abs(error) / std::max(plain, std::sqrt(robust(i, i))));
  }
  return worst;
}

}  // namespace kalfem
