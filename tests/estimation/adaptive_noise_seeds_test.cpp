// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "estimation/adaptive_chain.hpp"

// Right noise stays right, over many records.

namespace kalfem {
namespace {

using Eigen::Index;

TEST(AdaptiveNoiseSeeds, RightNoiseStaysRight) {
  const AdaptiveChain setting;
  double mean = 0.0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto record = setting.record(setting.disturbed, seed);
    const auto result = setting.run(record, {.sensors = true, .process = true}, AdaptiveChain::density);
    ASSERT_FALSE(result.failure) << seed;
    EXPECT_NEAR(relative_nis(result), 1.0, 0.1) << seed;
    const Index last = result.nis.size() - 1;
    for (Index i = 0; i < 4; ++i)
      EXPECT_NEAR(result.noise->sensors(i, last) / std::sqrt(record.noise(i, i)), 1.0, 0.15) << seed << " sensor " << i;
    const double log_factor = std::log(result.noise->process_factor[last]);
    EXPECT_LT(std::abs(log_factor), std::log(4.0)) << seed;
    mean += log_factor / 20.0;
  }
  EXPECT_NEAR(mean, 0.0, 0.5);
}

/// Without anything to explain, the process noise must not grow.
TEST(AdaptiveNoiseSeeds, ProcessNoiseOfNothingStaysInvisible) {
  const AdaptiveChain setting;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto record = setting.record(setting.undisturbed, seed);
    const auto result = setting.run(record, {.sensors = true, .process = true}, 0.0);
    ASSERT_FALSE(result.failure) << seed;
    EXPECT_NEAR(relative_nis(result), 1.0, 0.1) << seed;
    EXPECT_LT(worst_error(result), 4.0) << seed;
    EXPECT_LT(result.noise->density_at(result.nis.size() - 1), 0.2 * AdaptiveChain::density) << seed;
  }
}

}  // namespace
}  // namespace kalfem
