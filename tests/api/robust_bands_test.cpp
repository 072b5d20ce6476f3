// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "kalfem/api/estimate.hpp"
#include "kalfem/base/random.hpp"

// Bands of what no sensor measures, where estimates scatter more than the filter says. The force of a constant load is
// the unknown itself: its band is the parameter's.

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double rate = 100.0, noise = 1e-4;  // [Hz], [m]
constexpr Index samples = 2000;

/// A resting mass under an unknown load, whose sensor has noise that is correlated over some twenty samples.
Record resting_record(double correlation) {
  RandomStream random(4, "noise");
  VectorXd x(samples);
  double error = 0.0;
  for (Index k = 0; k < samples; ++k) {
    error = correlation * error + std::sqrt(1.0 - correlation * correlation) * random.normal();
    x[k] = 2.0 / 800.0 + noise * error;
  }
  return make_record(rate, {{"x", x}});
}

EstimateResult estimated(double correlation, double second_thoughts) {
  Structure structure;
  structure.add(lumped("body").mass("m", 2.0).spring("k", "ground", "m", 800.0, 4.0))
      .connect("load", "body.ground", "body.m", law("preload", {{"f0", 0.0}}));
  return estimate(structure, resting_record(correlation),
                  {.sensors = {{"x", displacement("body.m"), noise}},
                   .unknowns = {{"load.f0", {.initial = 0.0, .std = 5.0}}},
                   .outputs = {{"force", connector_force("load")}},
                   .initial_state = {{"body.m", {.displacement_std = 5e-3}}},
                   .deviation_stride = 1,
                   .second_thoughts = second_thoughts});
}

TEST(RobustBands, AreThoseOfTheRobustDeviation) {
  const auto found = estimated(0.95, std::numeric_limits<double>::infinity());
  const auto& load = found.parameters.at(0);
  EXPECT_GT(load.std_robust, 2.0 * load.std);
  const VectorXd& band = found.output("force").std;
  EXPECT_NEAR(band[samples - 1], load.std_robust, 1e-6 * load.std_robust);
  // before, by the same excess: the force is the unknown at all times
  const double excess = load.std_robust * load.std_robust - load.std * load.std;
  const double own = load.std_history[samples / 2];
  EXPECT_NEAR(band[samples / 2], std::sqrt(own * own + excess), 1e-6 * band[samples / 2]);
}

TEST(RobustBands, OfWhiteNoiseAreTheFilters) {
  const auto found = estimated(0.0, std::numeric_limits<double>::infinity());
  const auto& load = found.parameters.at(0);
  EXPECT_NEAR(found.output("force").std[samples - 1], load.std, 1e-6 * load.std);
}

TEST(RobustBands, AreSaidWhereNoStepsAreLeftForThem) {
  const auto found = estimated(0.95, 0.5);
  EXPECT_TRUE(std::ranges::any_of(found.left_out, [](const std::string& each) {
    return each.find("contradictions along the record") != std::string::npos;
  }));
}

}  // namespace
}  // namespace kalfem
