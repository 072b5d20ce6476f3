// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <limits>

#include "chain.hpp"
#include "kalfem/base/random.hpp"

// How many parts of a sample interval the estimates need, found by the library itself.

namespace kalfem {
namespace {

using testing::HasSubstr;

/// A hardening oscillator of 71 Hz with 2 % damping, nine samples a period.
constexpr double rate = 640.0, stiffness = 2e5, cubic = 4e9, damping = 20.0, mass = 1.0, noise = 3e-6;
constexpr Eigen::Index samples = 640;

SignalPtr drive() {
  return make_random({.rms = 60.0, .lower = 1.0, .upper = 150.0, .duration = 4.0, .fade_in = 0.1, .seed = 3});
}

Structure oscillator(double k, double k3, double c, double m) {
  Structure s;
  s.add(lumped("circuit").mass("m", m));
  s.connect("spring", "circuit.m", "ground", law("cubic", {{"k", k}, {"k3", k3}, {"c", c}}));
  s.force("drive", "circuit.m", drive());
  return s;
}

/// Displacements by the classical Runge-Kutta method of fourth order, 64 steps a sample: nothing of it is the filter's.
Record reference() {
  constexpr Eigen::Index steps = 64, halves = 2 * steps;
  const Eigen::VectorXd force = drive()->sample(0.0, 1.0 / (rate * halves), samples * halves + 1).col(0).matrix();
  const double h = 1.0 / (rate * steps);
  using State = Eigen::Array2d;
  const auto slope = [](const State& x, double f) {
    return State(x[1], (f - stiffness * x[0] - cubic * x[0] * x[0] * x[0] - damping * x[1]) / mass);
  };
  State x = State::Zero();
  Eigen::VectorXd values(samples);
  RandomStream random(5, "x");
  for (Eigen::Index step = 0; step < samples * steps; ++step) {
    if (step % steps == 0) values[step / steps] = x[0] + noise * random.normal();
    const double begin = force[2 * step], middle = force[2 * step + 1], end = force[2 * step + 2];
    const State a = slope(x, begin), b = slope(x + 0.5 * h * a, middle), c = slope(x + 0.5 * h * b, middle),
                d = slope(x + h * c, end);
    x += h / 6.0 * (a + 2.0 * b + 2.0 * c + d);
  }
  return make_record(rate, {{"x", values}});
}

EstimateResult estimate_with(std::optional<int> substeps, int step_order = 2) {
  return estimate(oscillator(1.5e5, 2e9, 30.0, 0.8), reference(),
                  {.sensors = {{"x", displacement("circuit.m"), noise}},
                   .unknowns = {{"spring.k", {.std = 5e4}},
                                {"spring.k3", {.std = 2e9}},
                                {"spring.c", {.std = 15.0}},
                                {"circuit.m.mass", {.std = 0.25}}},
                   .substeps = substeps,
                   .step_order = step_order,
                   .second_thoughts = std::numeric_limits<double>::infinity()});
}

/// Errors in standard deviations.
Eigen::Array4d errors_of(const EstimateResult& result) {
  const Eigen::Array4d truth(stiffness, cubic, damping, mass);
  Eigen::Array4d errors;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto& parameter = result.parameters[i];
    errors[static_cast<Eigen::Index>(i)] =
        std::abs(parameter.mean - truth[static_cast<Eigen::Index>(i)]) / parameter.std;
  }
  return errors;
}

TEST(Substeps, FourBiasALightlyDampedOscillatorByManyDeviationsAtNineSamplesAPeriod) {
  const auto result = estimate_with(4);
  ASSERT_TRUE(result.usable());
  EXPECT_EQ(result.substeps, 4);
  EXPECT_EQ(result.substep_bias.size(), 0);  // a number that is given is not checked
  EXPECT_GT(errors_of(result).maxCoeff(), 10.0) << errors_of(result).transpose();
  EXPECT_LT(result.mean_nis(0.2), 1.2);  // which the NIS does not show
}

TEST(Substeps, AreAsManyAsTheEstimatesNeed) {
  const auto result = estimate_with({});
  ASSERT_TRUE(result.usable());
  EXPECT_GE(result.substeps, 16);
  ASSERT_EQ(result.substep_bias.size(), 4);
  EXPECT_LE(result.substep_bias.maxCoeff(), 0.2);
  EXPECT_LT(errors_of(result).maxCoeff(), 3.0) << errors_of(result).transpose();
}

TEST(Substeps, OfFourthOrderAreFarFewer) {
  const auto quadratic = estimate_with({}, 4);
  ASSERT_TRUE(quadratic.usable());
  EXPECT_LE(quadratic.substeps, 4);
  ASSERT_EQ(quadratic.substep_bias.size(), 4);
  EXPECT_LE(quadratic.substep_bias.maxCoeff(), 0.2);
  EXPECT_LT(errors_of(quadratic).maxCoeff(), 3.0) << errors_of(quadratic).transpose();
  // found 0.1 standard deviations between four of fourth order and 128 of second
  const auto many = estimate_with(128), few = estimate_with(4, 4);
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_NEAR(few.parameters[i].mean, many.parameters[i].mean, 0.3 * many.parameters[i].std) << i;
}

TEST(Substeps, RefuseAStepOfThirdOrder) { EXPECT_THROW(estimate_with({}, 3), InvalidInput); }

/// An estimate from a record of slow motions, for which four substeps are enough.
EstimateResult of_slow_motions(std::optional<int> substeps, int step_order = 2) {
  const std::vector<SensorDescription> sensors = {{"a3", acceleration("body.2"), 2.0},
                                                  {"a5", acceleration("body.4"), 2.0}};
  const auto record =
      simulate(driven_chain(), {.sensors = sensors, .duration = 2.0, .sample_rate = 1000.0, .seed = 1}).record;
  return estimate(driven_chain(), record,
                  {.sensors = sensors,
                   .unknowns = {{"suspension.mu_k1", {.initial = 15, .std = 5}}},
                   .substeps = substeps,
                   .step_order = step_order});
}

/// What the embedded step of second order would shift is small: no second run is made.
TEST(Substeps, OfFourthOrderAreJudgedWithinTheRun) {
  const auto chosen = of_slow_motions({}, 4);
  EXPECT_EQ(chosen.substeps, 2);
  ASSERT_EQ(chosen.substep_bias.size(), 1);
  EXPECT_LE(chosen.substep_bias[0], 0.2);
  EXPECT_EQ(of_slow_motions(2, 4).parameters[0].mean, chosen.parameters[0].mean);
  const auto fine = of_slow_motions(8, 4).parameters[0];  // found 0.05 standard deviations away
  EXPECT_NEAR(chosen.parameters[0].mean, fine.mean, 0.1 * fine.std);
}

TEST(Substeps, StayAtFourWhereTheseAreEnough) {
  const auto chosen = of_slow_motions({});
  EXPECT_EQ(chosen.substeps, 4);
  ASSERT_EQ(chosen.substep_bias.size(), 1);
  EXPECT_LE(chosen.substep_bias[0], 0.2);
  EXPECT_EQ(of_slow_motions(4).parameters[0].mean, chosen.parameters[0].mean);
}

/// Four are compared with two: the error falls with the square of the substep.
TEST(Substeps, StateTheBiasThatIsLeft) {
  const auto chosen = of_slow_motions({});
  const auto two = of_slow_motions(2).parameters[0], four = chosen.parameters[0];
  EXPECT_NEAR(chosen.substep_bias[0], std::abs(four.mean - two.mean) / 3.0 / four.std, 1e-9);
}

/// Without an unknown nothing is there whose bias could be measured.
TEST(Substeps, AreTwoWithoutUnknowns) {
  const auto result = estimate(driven_chain(), chain_record(), {.sensors = chain_sensors()});
  EXPECT_EQ(result.substeps, 2);
  EXPECT_EQ(result.substep_bias.size(), 0);
}

}  // namespace
}  // namespace kalfem
