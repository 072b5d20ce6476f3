// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "chain.hpp"
#include "kalfem/base/random.hpp"

// A mass on two springs side by side, of which any record tells the sum only. By logarithms a filter that linearises
// about estimates that move becomes sure of each.

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double mass = 10.0, left = 3e4, right = 2e4, rate = 500.0, prior = 0.3;
constexpr Index samples = 2000;

/// Half waves of random size, each a tenth of a second long [N].
VectorXd driven(std::uint64_t seed) {
  RandomStream random(seed, "shaker");
  VectorXd force(samples);
  double size = 0.0;
  for (Index k = 0; k < samples; ++k) {
    const double phase = std::fmod(static_cast<double>(k) / rate, 0.1) / 0.1;
    if (k % 50 == 0) size = 100.0 * random.normal();
    force[k] = size * std::pow(std::sin(std::numbers::pi * phase), 2);
  }
  return force;
}

/// The springs' sum alone moves the mass.
Structure on_two_springs(const VectorXd& force) {
  Structure structure;
  structure.add(lumped("rig").mass("m", mass));
  structure.connect("left", "ground", "rig.m", law("linear", {{"k", left}, {"c", 40.0}}));
  structure.connect("right", "ground", "rig.m", law("linear", {{"k", right}, {"c", 0.0}}));
  structure.force("shaker", "rig.m", Samples{force, rate, 0.0});
  return structure;
}

EstimateResult estimate_springs(std::uint64_t seed, TransformKind transform) {
  const Structure structure = on_two_springs(driven(seed));
  const std::vector<SensorDescription> sensors{{"a", acceleration("rig.m"), 0.1}};
  const double duration = static_cast<double>(samples - 1) / rate;
  const auto found = simulate(structure, {.sensors = sensors, .duration = duration, .sample_rate = rate, .seed = seed});
  EstimateOptions options{.sensors = sensors, .outputs = {{"left", connector_force("left")}}};
  for (const auto& [name, initial] : {std::pair("left.k", 2.4e4), {"right.k", 3.2e4}})
    options.unknowns.push_back(
        {name, {.initial = initial, .std = prior * initial, .transform = ParameterTransform{transform}}});
  return estimate(structure, found.record, options);
}

std::vector<std::string> codes(const EstimateResult& result) {
  std::vector<std::string> all;
  for (const auto& reason : result.verdict.reasons()) all.push_back(reason.code);
  return all;
}

/// The stiffnesses given their sum have the covariance p^2 (k_r, -k_l) (k_r, -k_l)^T / (k_l^2 + k_r^2) in logarithms, p
/// the prior's deviation of each.
TEST(TooSure, IsAFilterOfTwoSpringsSideBySideByTheirLogarithms) {
  for (const std::uint64_t seed : {1, 3}) {
    const auto result = estimate_springs(seed, TransformKind::log);
    EXPECT_THAT(codes(result), testing::IsSupersetOf({"too_sure", "correlated"}));
    const double k_l = result.parameters[0].mean, k_r = result.parameters[1].mean;
    EXPECT_NEAR(k_l + k_r, left + right, 0.01 * (left + right));
    const double doubt = prior * k_l * k_r / std::hypot(k_l, k_r);
    for (std::size_t i = 0; i < 2; ++i) {
      const auto& found = result.parameters[i];
      EXPECT_LT(found.std, 0.2 * doubt);
      EXPECT_GT(found.std_robust, 0.98 * doubt);  // and how far the most likely value is away
      EXPECT_LT(found.std_robust, 2.0 * doubt);
    }
  }
}

TEST(TooSure, WidensTheBandsOfWhatNoSensorMeasures) {
  const auto found = estimate_springs(1, TransformKind::log).output("left");
  const auto truth = simulate(on_two_springs(driven(1)), {.sensors = {{"left", connector_force("left"), 1.0}},
                                                          .duration = static_cast<double>(samples - 1) / rate,
                                                          .sample_rate = rate});
  const Eigen::ArrayXd away = (found.mean - truth.record.values.row(0).transpose()).cwiseQuotient(found.std);
  EXPECT_GT((away.tail(samples / 2).abs() < 1.96).cast<double>().mean(), 0.9);
}

TEST(TooSure, IsNoFilterWhoseModelIsStraightAlongWhatTheRecordDoesNotTell) {
  const auto result = estimate_springs(1, TransformKind::none);
  EXPECT_THAT(codes(result), testing::Contains("correlated"));
  EXPECT_THAT(codes(result), testing::Not(testing::Contains("too_sure")));
  EXPECT_NEAR(result.parameters[0].std_robust / result.parameters[0].std, 1.0, 0.1);
}

}  // namespace
}  // namespace kalfem
