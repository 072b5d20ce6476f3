// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/signals/ground_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/system/signals/deterministic.hpp"
#include "kalfem/system/signals/random_signal.hpp"
#include "kalfem/system/signals/sampled.hpp"

namespace kalfem {
namespace {

constexpr double pi = std::numbers::pi;

/// Largest difference of value, rate and acceleration, each to the largest of the expected one.
double difference(const SignalSamples& found, const SignalSamples& expected) {
  double largest = 0.0;
  for (int d = 0; d < 3; ++d)
    largest = std::max(largest, (found - expected).col(d).abs().maxCoeff() / expected.col(d).abs().maxCoeff());
  return largest;
}

/// The signal's second derivative as samples.
SignalPtr recorded_acceleration(const Signal& motion, double rate, double duration) {
  const auto count = Eigen::Index(rate * duration) + 1;
  return make_sampled(motion.sample(0.0, 1.0 / rate, count).col(2), {.sample_rate = rate});
}

TEST(GroundMotion, IsTheMotionWhoseAccelerationWasRecorded) {
  // the spline through the samples of a pulse of 2 s errs with the fourth power of their distance: 3.6e-5 and 2.3e-6
  const auto motion = make_pulse({.amplitude = 0.02, .start = 1.0, .duration = 2.0, .shape = PulseShape::smooth});
  const GroundMotion found(recorded_acceleration(*motion, 100.0, 5.0), {.step = 0.01, .knots = 501});
  // found 3.6e-5, and 2.3e-6 at half the interval: fourth order
  EXPECT_LT(difference(found.sample(0.0, 0.0037, 1351), motion->sample(0.0, 0.0037, 1351)), 5e-5);
  const GroundMotion finer(recorded_acceleration(*motion, 400.0, 5.0), {.step = 0.0025, .knots = 2001});
  EXPECT_LT(difference(finer.sample(0.0, 0.0037, 1351), motion->sample(0.0, 0.0037, 1351)), 4e-6);
  EXPECT_EQ(found.removed().part, 0.0);
}

TEST(GroundMotion, IntegratesACubicSplineExactly) {
  // a = t^3 - t: r = t^5 / 20 - t^3 / 6
  const Eigen::ArrayXd t = Eigen::ArrayXd::LinSpaced(11, 0.0, 2.0);
  const GroundMotion found(make_sampled((t.cube() - t).matrix(), {.sample_rate = 5.0}), {.step = 0.2, .knots = 11});
  const auto s = found.sample(1.93, 1.0, 1);
  // the spline is this polynomial: rounding
  EXPECT_NEAR(s(0, 0), std::pow(1.93, 5) / 20 - std::pow(1.93, 3) / 6, 3e-15);
  EXPECT_NEAR(s(0, 1), std::pow(1.93, 4) / 4 - std::pow(1.93, 2) / 2, 3e-15);
  EXPECT_NEAR(s(0, 2), std::pow(1.93, 3) - 1.93, 2e-14);
  EXPECT_NO_THROW((void)found.sample(0.0, 0.1, 21));
  EXPECT_THROW((void)found.sample(0.0, 0.1, 22), InvalidInput);
}

TEST(GroundMotion, StepsAndSpeedsRemainWhenTheDriftIsKept) {
  const auto step = make_step({.after = 0.3, .start = 1.0, .duration = 0.5});  // the ground ends 0.3 m further
  const GroundMotion found(recorded_acceleration(*step, 1000.0, 4.0), {.step = 1e-3, .knots = 4001});
  // found 2e-5: fourth order in the interval
  EXPECT_LT(difference(found.sample(0.0, 0.01, 401), step->sample(0.0, 0.01, 401)), 5e-5);
  const GroundMotion falling(make_constant(-9.81), {.step = 0.1, .knots = 11});
  const auto later = falling.sample(3.0, 1.0, 1), before = falling.sample(-2.0, 1.0, 1);  // beyond its knots
  // the spline holds a constant: rounding
  EXPECT_NEAR(later(0, 0), -0.5 * 9.81 * 9.0, 3e-13);
  EXPECT_NEAR(later(0, 1), -9.81 * 3.0, 3e-13);
  EXPECT_NEAR(before(0, 0), -0.5 * 9.81 * 4.0, 1e-13);
}

TEST(GroundMotion, AnOffsetAndAStartInMotionAreTakenOut) {
  // a record that begins while the ground moves, by an accelerometer with an offset of 0.2 m/s^2
  const auto motion = make_random({.rms = 2e-3, .lower = 1.0, .upper = 20.0, .fade_in = 0.0});
  const auto acceleration = sum({recorded_acceleration(*motion, 1000.0, 20.0), make_constant(0.2)});
  const IntegrationOptions options{.step = 1e-3, .knots = 20001, .drift = Drift::remove};
  const GroundMotion found(acceleration, options);
  const auto expected = motion->sample(0.0, 0.01, 2001);
  // what is left is what the window sees of the motion itself: about its lowest frequency's turns to the power -3
  EXPECT_LT(difference(found.sample(0.0, 0.01, 2001), expected), 3e-5);
  EXPECT_GT(found.removed().part, 1000.0);
  EXPECT_NEAR(found.removed().offset, 0.2, 2e-9);
  EXPECT_NEAR(found.removed().velocity, -motion->sample(0.0, 1.0, 1)(0, 1), 3e-8);
  const GroundMotion kept(acceleration, {.step = 1e-3, .knots = 20001});
  EXPECT_GT(std::abs(kept.sample(20.0, 1.0, 1)(0, 0)), 10.0);
}

TEST(GroundMotion, AMotionAboutItsRestIsHardlyTouched) {
  const auto motion = make_random({.rms = 2e-3, .lower = 1.0, .upper = 20.0});
  const GroundMotion found(recorded_acceleration(*motion, 1000.0, 20.0),
                           {.step = 1e-3, .knots = 20001, .drift = Drift::remove});
  EXPECT_LT(found.removed().part, 1.5e-3);  // found 6e-4
}

TEST(GroundMotion, GoesOnOutsideItsKnots) {
  const auto swept = make_swept_sine({.from = 2.0, .to = 6.0, .duration = 5.0});
  const GroundMotion whole(swept, {.step = 1e-3, .knots = 9001, .drift = Drift::keep});
  const GroundMotion part(swept, {.step = 1e-3, .knots = 2001, .drift = Drift::keep});
  EXPECT_LT(difference(part.sample(1.0, 0.01, 700), whole.sample(1.0, 0.01, 700)), 5e-13);  // rounding
  const auto before = part.sample(-1.0, 0.5, 5);
  EXPECT_NEAR(before(4, 0), whole.sample(1.0, 1.0, 1)(0, 0), 1e-14);  // the same spline
  EXPECT_NEAR(before(0, 2), swept->sample(-1.0, 1.0, 1)(0, 0), 1e-12);
  EXPECT_THROW((void)part.sample(1e12, 1.0, 1), InvalidInput);
}

TEST(GroundMotion, SinesAndRandomSignalsAreIntegratedLineByLine) {
  const double w = 2.0 * pi * 3.0;
  const auto sine = make_sine({.amplitude = 2.0, .frequency = 3.0, .phase = 0.4, .integrated_twice = true});
  const auto expected = make_sine({.amplitude = -2.0 / (w * w), .frequency = 3.0, .phase = 0.4});
  // the same closed form
  EXPECT_LT(difference(sine->sample(0.0, 0.013, 500), expected->sample(0.0, 0.013, 500)), 1e-14);
  RandomSignalOptions options{.rms = 2.0, .fade_in = 0.0, .seed = 4};
  const auto acceleration = make_random(options);
  options.integrated_twice = true;
  const auto displacement = make_random(options);
  const auto a = acceleration->sample(0.0, 0.01, 2000), r = displacement->sample(0.0, 0.01, 2000);
  EXPECT_LT((a.col(0) - r.col(2)).abs().maxCoeff(), 5e-14);  // rounding of the transform
  EXPECT_LT(std::abs(r.col(0).mean()), 1e-16);
  options.fade_in = 0.5;
  EXPECT_EQ(make_random(options)->sample(0.0, 1.0, 1).abs().maxCoeff(), 0.0);
}

TEST(GroundMotion, PulsesAreIntegratedInClosedForm) {
  for (const auto shape : {PulseShape::half_sine, PulseShape::smooth}) {
    PulseOptions options{.amplitude = 3.0, .start = 0.2, .duration = 0.3, .shape = shape};
    const GroundMotion expected(make_pulse(options), {.start = 0.2, .step = 1e-3, .knots = 301});  // up to its end
    options.integrated_twice = true;
    const auto found = make_pulse(options);
    // the pulse is its own polynomial: rounding
    EXPECT_LT(difference(found->sample(0.2, 0.0029, 103), expected.sample(0.2, 0.0029, 103)), 2e-13);
    const auto end = found->sample(0.5, 1.0, 2);  // later the speed stays
    // the same sum
    EXPECT_NEAR(end(1, 0), end(0, 0) + end(0, 1), 1e-15);
    EXPECT_NEAR(end(1, 1), 3.0 * 0.3 * (shape == PulseShape::smooth ? 0.375 : 2.0 / pi), 2e-15);  // rounding
    EXPECT_EQ(found->sample(0.1, 1.0, 1).abs().maxCoeff(), 0.0);
  }
}

TEST(GroundMotion, RefusesUnsuitableOptions) {
  EXPECT_THROW(GroundMotion(nullptr, {}), InvalidInput);
  EXPECT_THROW(GroundMotion(make_constant(1.0), {.step = 0.0}), InvalidInput);
  EXPECT_THROW(GroundMotion(make_constant(1.0), {.knots = 1}), InvalidInput);
}

}  // namespace
}  // namespace kalfem
