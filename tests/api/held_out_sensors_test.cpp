// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <cmath>

#include "chain.hpp"

// Sensors held out as virtual ones: of a chain that is modelled right, and of one with friction that the model lacks.

namespace kalfem {
namespace {

using testing::HasSubstr;

constexpr double rate = 200.0, duration = 12.0;

Structure chain_of_four(double friction) {
  Structure s;
  s.add(lumped("s")
            .mass("1", 2.0)
            .mass("2", 2.0)
            .mass("3", 2.0)
            .mass("4", 1.0)
            .spring("k1", "ground", "1", 6e3, 6.0)
            .spring("k2", "1", "2", 8e3, 6.0)
            .spring("k4", "3", "4", 5e3, 4.0));
  s.connect("joint", "s.2", "s.3", expression("k*x + k3*x^3 + c*v", {{"k", 8e3}, {"k3", 2e7}, {"c", 8.0}}));
  if (friction > 0.0) s.connect("rub", "s.1", "ground", expression("f*tanh(v/0.005)", {{"f", friction}}));
  const Eigen::VectorXd t = Eigen::VectorXd::LinSpaced(2401, 0.0, duration);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(t.size());
  for (int i = 0; i < 30; ++i)
    force += 8.0 * (2.0 * M_PI * (1.0 + 0.55 * i + 0.3 * std::sin(7.0 * i)) * t.array() + 2.4 * i * i).sin().matrix();
  s.force("shaker", "s.1", Samples{force.cwiseProduct(t.cwiseMin(0.5) / 0.5), rate, 0.0});
  return s;
}

EstimateOptions options() {
  EstimateOptions o;
  o.sensors = {{"a2", acceleration("s.2"), 0.5}, {"a4", acceleration("s.4"), 0.5}};
  o.unknowns = {{"joint.k", {.initial = 8.4e3, .std = 800.0}}, {"joint.k3", {.initial = 2.2e7, .std = 4e6}}};
  return o;
}

EstimateResult estimated(double friction, std::uint64_t seed, const EstimateOptions& o) {
  const Record record =
      simulate(chain_of_four(friction),
               {.sensors = options().sensors, .duration = duration, .sample_rate = rate, .seed = seed})
          .record;
  return estimate(chain_of_four(0.0), record, o);
}

/// Of 2280 samples .95 +- .0046: .93 lies 4 of these deviations away.
TEST(HeldOutSensors, OfARightModelLieInTheirBands) {
  for (std::uint64_t seed = 1; seed < 4; ++seed) {
    const auto result = estimated(0.0, seed, options());
    ASSERT_EQ(result.held_out_sensors.size(), 2u);
    for (const auto& sensor : result.held_out_sensors) {
      EXPECT_TRUE(sensor.holds()) << sensor.name;
      EXPECT_NEAR(sensor.inside, 0.95, 0.02) << sensor.name;
      EXPECT_LT(sensor.motion_deviation, sensor.noise);
    }
    EXPECT_FALSE(result.adapted_process);
  }
}

TEST(HeldOutSensors, WithoutAForceContradictTheirBands) {
  const auto result = estimated(0.08, 1, options());
  ASSERT_EQ(result.held_out_sensors.size(), 2u);
  const auto doubted = std::ranges::find_if(result.held_out_sensors, [](const auto& each) { return !each.holds(); });
  ASSERT_NE(doubted, result.held_out_sensors.end());
  EXPECT_LT(doubted->motion_inside, 0.8);
  const auto reasons = result.verdict.reasons();
  const auto reason = std::ranges::find(reasons, "band_too_narrow", &Reason::code);
  ASSERT_NE(reason, reasons.end());
  EXPECT_EQ(reason->state, VerdictState::suspicious);
  EXPECT_THAT(reason->text, HasSubstr("of its motion"));
}

TEST(HeldOutSensors, AreNamedWhereStepsDoNotSuffice) {
  auto o = options();
  o.second_thoughts = 0.1;
  const auto result = estimated(0.0, 1, o);
  EXPECT_TRUE(result.held_out_sensors.empty());
  EXPECT_THAT(result.left_out, testing::Contains(HasSubstr("a2, a4")));
}

TEST(HeldOutSensors, AdaptiveProcessNoiseIsAnOption) {
  auto o = options();
  o.process_noise = 0.03;
  o.adaptive_noise = {.process = true};
  const auto result = estimated(1.0, 1, o);
  EXPECT_FALSE(result.adapted_process);  // the run adapts already
  for (const auto& sensor : result.held_out_sensors) EXPECT_TRUE(sensor.holds()) << sensor.name;
}

}  // namespace
}  // namespace kalfem
