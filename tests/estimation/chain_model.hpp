// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>

#include "kalfem/base/random.hpp"
#include "kalfem/dynamics/converged_solution.hpp"
#include "kalfem/estimation/consistency.hpp"
#include "kalfem/estimation/estimate.hpp"
#include "kalfem/records/record.hpp"
#include "kalfem/system/signals/random_signal.hpp"
#include "system/small_systems.hpp"

namespace kalfem {

/// Prior and noise of the right sizes, all zero: everything known, starting at rest.
inline AugmentedModelOptions all_known(const LocallyNonlinearSystem& system, double step) {
  const Eigen::VectorXd dofs = Eigen::VectorXd::Zero(system.size()),
                        inputs = Eigen::VectorXd::Zero(system.input_count()),
                        states = Eigen::VectorXd::Zero(system.connector_states());
  AugmentedModelOptions options;
  options.step = step;
  options.process_noise = {dofs, inputs, states};
  options.prior = {at_rest(system.size(), system.connector_states()), dofs, dofs, states, inputs, inputs, 0.0};
  return options;
}

/// The eleven-degree-of-freedom chain of Tsotalou et al. (2017), case 1, with values of this project: a wheel on a
/// moving ground, a saturating suspension, ten masses with 1 % modal damping. Sensors: accelerations at DOFs 3, 5, 7
/// and 11.
struct Chain {
  static constexpr double rate = 1000.0;  // [Hz]
  static constexpr double mu_k1 = 20.0, mu_c1 = 10.0;

  double body_stiffness = 3e4;  // of each spring of the body [N/m]
  CoupledModel model = make_model(body_stiffness);
  OutputMap sensors =
      make_outputs(model, {acceleration("2"), acceleration("4"), acceleration("6"), acceleration("10")});
  SignalPtr road = make_random({.rms = 3e-3, .lower = 0.5, .upper = 30.0, .duration = 20.0, .fade_in = 0.5, .seed = 7});

  static OutputDescription acceleration(const std::string& mass) {
    return {"a" + mass, ObservedQuantity::acceleration, {{"body." + mass, 1.0}}};
  }
  /// DOF 4: the third mass of the body.
  [[nodiscard]] OutputMap displacement_of_dof_4() const {
    return make_outputs(model, {{"d4", ObservedQuantity::displacement, {{"body.3", 1.0}}}});
  }

  /// Newmark's method, refined until the records stop moving: another discretisation than the filter's.
  [[nodiscard]] ConvergedSolution reference(double duration, double sample_rate = rate) const {
    return simulate_converged(model.system(), {road}, at_rest(11, 0), sensors, {},
                              {.integrator = Integrator::newmark, .duration = duration},
                              {.sample_rate = sample_rate, .max_substeps = 64, .tolerance = 2e-3});
  }

  /// [r; r'; r''] of the road at `rate`, 3 x count.
  [[nodiscard]] Eigen::MatrixXd inputs(double sample_rate, Eigen::Index count) const {
    return road->sample(0.0, 1.0 / sample_rate, count).matrix().transpose();
  }

  /// Leaves one measurement in `every`: the augmented model's step is then finer than the sampling interval.
  static void thin_out(FilterInput& record, Eigen::Index every) {
    for (Eigen::Index k = 0; k < record.measured.samples(); ++k)
      if (k % every != 0) record.measured.values.col(k).setConstant(std::numeric_limits<double>::quiet_NaN());
  }

  /// The reference with white noise of 15 % of each channel's rms.
  static FilterInput record(const ConvergedSolution& reference, std::uint64_t seed) {
    FilterInput record{{.values = reference.sensors}, reference.simulation.trajectory.inputs, {}};
    Eigen::VectorXd deviation(record.measured.values.rows());
    for (Eigen::Index i = 0; i < deviation.size(); ++i) {
      RandomStream random(seed, "noise " + std::to_string(i));
      deviation[i] = 0.15 * rms(reference.sensors.row(i).transpose());
      for (Eigen::Index k = 0; k < record.measured.samples(); ++k)
        record.measured.values(i, k) += deviation[i] * random.normal();
    }
    record.noise = deviation.cwiseAbs2().asDiagonal();
    return record;
  }

  /// Guesses of 50 % and 160 % of the truth with a standard deviation of half the guess.
  [[nodiscard]] AugmentedModelOptions options(TransformKind transform = TransformKind::log,
                                              double sample_rate = rate) const {
    auto options = all_known(model.system(), 1.0 / sample_rate);
    options.unknowns = {{"mu_k1", "N", {{0, 1}}, {transform, 0.0, 100.0}, 0.5 * mu_k1, 0.25 * mu_k1},
                        {"mu_c1", "N", {{0, 4}}, {transform, 0.0, 100.0}, 1.6 * mu_c1, 0.8 * mu_c1}};
    options.prior.displacement_deviation.setConstant(1e-5);
    options.prior.velocity_deviation.setConstant(1e-3);
    return options;
  }

  static CoupledModel make_model(double body_stiffness, std::vector<ConnectorDescription> more = {}) {
    LumpedSubstructure wheel, body;
    wheel.masses = {{"w", 1.5}};
    wheel.springs = {{"tyre", "ground", "w", 2e4}};
    for (int i = 1; i <= 10; ++i) {
      body.masses.push_back({std::to_string(i), 1.0});
      if (i > 1)
        body.springs.push_back({"s" + std::to_string(i), std::to_string(i - 1), std::to_string(i), body_stiffness});
    }
    body.modal_damping = {0.01};
    const auto parameters = values({5e3, mu_k1, 2e-3, 10.0, mu_c1, 0.05});
    more.insert(more.begin(), {"suspension", "wheel.w", "body.1", make_law("saturating"), parameters});
    return CoupledModel({{"wheel", assemble(wheel)}, {"body", assemble(body)}}, more,
                        {{"road", InputKind::base_displacement, "wheel.ground"}});
  }
};

}  // namespace kalfem
