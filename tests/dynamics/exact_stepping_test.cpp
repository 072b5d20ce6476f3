// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "dynamics/closed_forms.hpp"
#include "kalfem/base/random.hpp"
#include "kalfem/system/signals/deterministic.hpp"

namespace kalfem {
namespace {

const DampedOscillator body{1.5, 8.0, 2e4};

TEST(ExactStepping, FreeVibrationIsExactAtAnyStep) {
  const auto model = oscillator(body.m, body.c, body.k);
  for (const double h : {1e-4, 7e-3, 0.13, 1.7}) {  // from 500 steps a period down to 30 periods a step
    const auto result =
        simulate(model.system(), {make_constant(0.0)}, start_at(2e-3, -0.1), {.step = h, .duration = 10 * h});
    ASSERT_FALSE(result.failure);
    const auto expected = body.free(2e-3, -0.1, 10 * h);
    // rounding of the matrix exponential, a few hundred roundings of the state's size
    EXPECT_NEAR(result.trajectory.displacement(0, 10), expected[0], 1e-14 * 2e-3) << h;
    EXPECT_NEAR(result.trajectory.velocity(0, 10), expected[1], 1e-14 * 0.25) << h;
  }
}

TEST(ExactStepping, RampResponseIsExactAtAnyStep) {
  const auto model = oscillator(body.m, body.c, body.k);
  const double rate = 300.0;
  for (const double h : {1e-3, 0.05, 0.4}) {
    const double T = 5 * h;
    const auto ramp = straight_lines(values({0.0, rate * T}), 1.0 / T);
    const auto result = simulate(model.system(), {ramp}, at_rest(1, 0), {.step = h, .duration = T});
    for (Eigen::Index k = 0; k <= 5; ++k) {
      const double t = static_cast<double>(k) * h;
      const auto expected = body.ramp(rate, t);
      // found 1e-15 of the static deflection: rounding
      EXPECT_NEAR(result.trajectory.displacement(0, k), expected[0], 1e-13 * rate * T / body.k) << h;
      EXPECT_NEAR(result.trajectory.acceleration(0, k),
                  (rate * t - body.c * expected[1] - body.k * expected[0]) / body.m, 1e-14 * rate * T / body.m)
          << h;
    }
  }
}

TEST(ExactStepping, OneStepPerKinkEqualsManyStepsPerKink) {
  // Forces that are straight between samples: the answer at the samples does not depend on the step, here for ten
  // degrees of freedom with frequencies far above one over the step.
  const auto model = quarter_chain(9, {}, {{"F", InputKind::force, "wheel.w"}, {"G", InputKind::force, "body.4"}});
  RandomStream random(11, "kinks");
  const auto draw = [&] { return Eigen::VectorXd::NullaryExpr(51, [&] { return random.normal(); }).eval(); };
  const std::vector<SignalPtr> forces{straight_lines(draw(), 50.0), straight_lines(draw(), 50.0)};
  const auto rest = at_rest(10, 0);
  const auto big = simulate(model.system(), forces, rest, {.step = 0.02, .duration = 1.0});
  const auto small = simulate(model.system(), forces, rest, {.step = 0.02 / 64, .duration = 1.0, .keep_every = 64});
  ASSERT_EQ(big.trajectory.samples(), 51);
  ASSERT_EQ(small.trajectory.samples(), 51);
  const double size = big.trajectory.displacement.cwiseAbs().maxCoeff();
  // rounding of 3200 small steps: found 1.6e-12
  EXPECT_LT((big.trajectory.displacement - small.trajectory.displacement).cwiseAbs().maxCoeff(), 1e-11 * size);
  const double speed = big.trajectory.velocity.cwiseAbs().maxCoeff();
  EXPECT_LT((big.trajectory.velocity - small.trajectory.velocity).cwiseAbs().maxCoeff(), 1e-11 * speed);
}

TEST(ExactStepping, BaseAccelerationAndBaseDisplacementGiveTheSameRelativeMotion) {
  const auto saturating = [](const std::string& from) {
    return ConnectorDescription{"strut_" + from, from, "body.1", make_law("saturating"), saturating_parameters()};
  };
  const std::vector<ConnectorDescription> struts{saturating("wheel.w"), saturating("wheel.ground")};
  const auto absolute = quarter_chain(3, struts, {{"road", InputKind::base_displacement, "wheel.ground"}});
  const auto relative = quarter_chain(3, struts, {{"quake", InputKind::base_acceleration, ""}});
  const double amplitude = 3e-3, frequency = 7.0;
  const auto road = make_sine({.amplitude = amplitude, .frequency = frequency, .fade_in = 0.2});
  const double h = 1e-4;
  const Eigen::Index samples = 5001;
  const auto quake = straight_lines(road->sample(0.0, h, samples).col(2).matrix(), 1.0 / h);
  const SimulationOptions options{.step = h, .duration = 0.5};
  const auto a = simulate(absolute.system(), {road}, at_rest(4, 0), options).trajectory;
  const auto r = simulate(relative.system(), {quake}, at_rest(4, 0), options).trajectory;
  const Eigen::MatrixXd moved = a.displacement.rowwise() - a.inputs.row(0);
  // Both interpolate inputs and forces linearly over the step: found 1e-6 to 2e-6.
  EXPECT_LT((moved - r.displacement).cwiseAbs().maxCoeff(), 3e-6 * r.displacement.cwiseAbs().maxCoeff());
  EXPECT_LT((a.force - r.force).cwiseAbs().maxCoeff(), 4e-6 * r.force.cwiseAbs().maxCoeff());
  const OutputDescription sensor{"a", ObservedQuantity::acceleration, {{"body.2", 1.0}}};
  const auto y_a = make_outputs(absolute, {sensor}), y_r = make_outputs(relative, {sensor});
  const Eigen::VectorXd from_a = (y_a.acceleration * a.acceleration).transpose();
  const Eigen::VectorXd from_r =
      (y_r.acceleration * r.acceleration + y_r.input_value * r.inputs.topRows(1)).transpose();
  EXPECT_LT((from_a - from_r).norm(), 4e-6 * from_a.norm());
}

}  // namespace
}  // namespace kalfem
