// SPDX-License-Identifier: Apache-2.0
#include "kalfem/dynamics/first_order_form.hpp"

#include <gtest/gtest.h>
#include <limits>

#include "dynamics/closed_forms.hpp"
#include "kalfem/system/signals/random_signal.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

const DampedOscillator rider{1.2, 6.0, 5e3};
constexpr auto no_law = [](double, double) { return 0.0; };

OutputMap sensor(const CoupledModel& model, ObservedQuantity quantity) {
  return make_outputs(model, {{"s", quantity, {{"body.x", 1.0}}}});
}

TEST(FirstOrderForm, IntegratedAccelerationReproducesThePrescribedGroundMotion) {
  // r = b t^3: r'' = 6 b t is straight, so the integrated input is exact at any step.
  const double b = 0.4, h = 0.05;
  const auto model = oscillator(rider.m, rider.c, rider.k, {}, {{"road", InputKind::base_displacement, "body.ground"}});
  const FirstOrderForm form(model.system(), sensor(model, ObservedQuantity::acceleration), {},
                            {{.model = InputModel::integrated}});
  ASSERT_EQ(form.size(), 4);
  ASSERT_EQ(form.input_state(0), 2);
  const ExactStep step(form, h);
  VectorXd x = VectorXd::Zero(4);
  const auto input = [&](double t) { return values({1e9, -1e9, 6 * b * t}); };  // r and r' given must not matter
  for (int k = 0; k < 20; ++k)
    x = step.transition * x + step.begin_input * input(k * h) + step.end_input * input((k + 1) * h);
  const double T = 20 * h;
  // rounding of twenty steps
  EXPECT_NEAR(x[2], b * T * T * T, 5e-15);
  EXPECT_NEAR(x[3], 3 * b * T * T, 1e-14);
  const auto pull = [&](double t) { return rider.k * b * t * t * t + rider.c * 3 * b * t * t; };
  const auto expected = runge_kutta(rider, pull, no_law, 0.0, 0.0, T, 40000);
  EXPECT_NEAR(x[0], expected[0], 1e-14);  // Runge-Kutta: (omega h)^4 = 7e-12 of what the step turns
  EXPECT_NEAR(x[1], expected[1], 2e-13);
  const double y = (form.outputs().state * x + form.outputs().input * input(T))[0];
  // rounding: differences of forces of 2,000 N, found 2e-12
  EXPECT_NEAR(y, (pull(T) - rider.c * x[1] - rider.k * x[0]) / rider.m, 2e-11);
}

TEST(FirstOrderForm, IntegratedInputMovesTheConnectorsGround) {
  const auto model =
      oscillator(rider.m, 0.0, 0.0, {{"strut", "body.ground", "body.x", make_law("linear"), values({1.0, 1.0})}},
                 {{"road", InputKind::base_displacement, "body.ground"}});
  const FirstOrderForm form(model.system(), sensor(model, ObservedQuantity::displacement), {},
                            {{.model = InputModel::integrated}});
  const VectorXd x = values({0.5, 0.7, 0.2, 0.3}), input = values({9.0, 9.0, 4.0});
  const VectorXd motion = form.motion().state * x + form.motion().input * input;
  EXPECT_DOUBLE_EQ(motion[0], 0.5 - 0.2);
  EXPECT_DOUBLE_EQ(motion[1], 0.7 - 0.3);
  EXPECT_DOUBLE_EQ(motion[2], -4.0);
}

TEST(FirstOrderForm, MarkovForceDecaysAndDrives) {
  const double tau = 0.3, h = 0.02;
  const auto model = oscillator(rider.m, rider.c, rider.k);
  const FirstOrderForm form(model.system(), sensor(model, ObservedQuantity::acceleration), {},
                            {{.model = InputModel::latent, .process = {.correlation_time = tau}}});
  ASSERT_EQ(form.size(), 3);
  const ExactStep step(form, h);
  VectorXd x = values({0.0, 0.0, 50.0});
  for (int k = 0; k < 25; ++k) x = (step.transition * x).eval();
  const double T = 25 * h;
  EXPECT_NEAR(x[2], 50.0 * std::exp(-T / tau), 1e-13);  // found 9e-15: 25 roundings of 50 N
  const auto expected = runge_kutta(
      rider, [&](double t) { return 50.0 * std::exp(-t / tau); }, no_law, 0.0, 0.0, T, 40000);
  // rounding of a motion of .01 m; Runge-Kutta with 40,000 steps leaves less
  EXPECT_NEAR(x[0], expected[0], 5e-15);
  EXPECT_NEAR((form.outputs().state * x)[0], (x[2] - rider.c * x[1] - rider.k * x[0]) / rider.m, 1e-14);
}

TEST(FirstOrderForm, InfiniteCorrelationTimeIsARandomWalk) {
  const auto model = oscillator(rider.m, rider.c, rider.k);
  const FirstOrderForm form(model.system(), sensor(model, ObservedQuantity::displacement), {},
                            {{InputModel::latent, {1, std::numeric_limits<double>::infinity()}}});
  EXPECT_EQ(form.dynamics()(2, 2), 0.0);
}

TEST(FirstOrderForm, SensorStatesEqualFilteringAfterwards) {
  const auto model = quarter_chain(3, {}, {{"road", InputKind::base_displacement, "wheel.ground"}}, 0.02);
  const auto outputs = make_outputs(model, {{"a", ObservedQuantity::acceleration, {{"body.1", 1.0}}},
                                            {"b", ObservedQuantity::acceleration, {{"wheel.w", 1.0}}},
                                            {"c", ObservedQuantity::displacement, {{"wheel.w", 1.0}}}});
  const std::vector<MeasurementChain> chains{
      MeasurementChain({.sections = {FilterSection{.cutoff = 60.0}}}),
      MeasurementChain({.sections = {GainSection{2.0}, DelaySection{.delay = 2e-3, .order = 4}}}), MeasurementChain{}};
  const auto road = make_random({.rms = 3e-3, .lower = 0.5, .upper = 30.0, .duration = 2.0, .fade_in = 0.3, .seed = 5});
  const auto error = [&](double h) {
    const auto steps = static_cast<Index>(std::llround(1.0 / h));
    const FirstOrderForm form(model.system(), outputs, chains), bare(model.system(), outputs);
    EXPECT_EQ(form.size(), 8 + 4 + 4);
    const ExactStep step(form, h);
    VectorXd x = VectorXd::Zero(form.size());
    const SignalSamples r = road->sample(0.0, h, steps + 1);
    MatrixXd behind(steps + 1, 3), raw(steps + 1, 3);
    for (Index k = 0; k <= steps; ++k) {
      const VectorXd u = r.row(k).transpose().matrix();
      if (k > 0) x = step.transition * x + step.begin_input * r.row(k - 1).transpose().matrix() + step.end_input * u;
      behind.row(k) = (form.outputs().state * x + form.outputs().input * u).transpose();
      raw.row(k) = (bare.outputs().state * x.head(8) + bare.outputs().input * u).transpose();
    }
    double worst = 0.0;
    for (Index j = 0; j < 3; ++j) {
      const VectorXd filtered = chains[std::size_t(j)].filter(raw.col(j), 1.0 / h);
      worst = std::max(worst, (behind.col(j) - filtered).norm() / filtered.norm());
    }
    return worst;
  };
  // Filtering afterwards takes the record as straight between its samples; the states do not: second order in the step.
  const double coarse = error(1e-3), fine = error(2.5e-4);
  // found 2e-5
  EXPECT_LT(fine, 6e-5);
  EXPECT_GT(coarse / fine, 12.0);
}

TEST(FirstOrderForm, UnsuitableTreatmentsAndChainsAreRefused) {
  const auto model = oscillator(rider.m, rider.c, rider.k);
  const auto outputs = sensor(model, ObservedQuantity::displacement);
  for (const double tau : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THROW(FirstOrderForm(model.system(), outputs, {}, {{InputModel::latent, {1, tau}}}), InvalidInput);
  EXPECT_THROW(FirstOrderForm(model.system(), outputs, {}, {{}, {}}), InvalidInput);
  EXPECT_THROW(FirstOrderForm(model.system(), outputs, {MeasurementChain{}, MeasurementChain{}}), InvalidInput);
}

}  // namespace
}  // namespace kalfem
