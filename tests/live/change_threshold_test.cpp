// SPDX-License-Identifier: Apache-2.0
#include "kalfem/live/change_threshold.hpp"

#include <gtest/gtest.h>

#include <random>

namespace kalfem {
namespace {

/// Crossings per value of max |S_n - S_k| / sqrt(n - k) over n - k <= memory; after one, `memory` values are passed
/// over.
double counted_rate(double threshold, int memory, int values) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  std::vector<double> sums{0.0};
  int crossings = 0, passed = 0;
  for (int n = 1, free_from = memory; n <= values; ++n) {
    sums.push_back(sums.back() + normal(random));
    if (n < free_from) {
      ++passed;
      continue;
    }
    for (int k = n - memory; k < n; ++k)
      if (std::abs(sums[size_t(n)] - sums[size_t(k)]) > threshold * std::sqrt(n - k)) {
        ++crossings;
        free_from = n + memory + 1;
        break;
      }
  }
  return crossings / double(values - passed);
}

TEST(ChangeThreshold, GivesTheRateOfFalseAlarmsThatIsCounted) {
  EXPECT_NEAR(false_alarm_rate(3.5, 60) / counted_rate(3.5, 60, 400'000), 1.0, 0.25);
  EXPECT_NEAR(false_alarm_rate(3.5, 10) / counted_rate(3.5, 10, 400'000), 1.0, 0.35);
}

TEST(ChangeThreshold, IsThatOfTheStatedTime) {
  const double threshold = change_threshold(18'000, 60, 20);
  EXPECT_NEAR(18'000 * 20 * false_alarm_rate(threshold, 60), 1.0, 1e-6);
  EXPECT_GT(threshold, change_threshold(18'000, 60, 1));
  EXPECT_GT(threshold, change_threshold(1'800, 60, 20));
}

}  // namespace
}  // namespace kalfem
