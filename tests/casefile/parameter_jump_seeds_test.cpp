// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "casefile/changing_chain.hpp"

// Heavy: how well the time and size of a change are found over many records, and how often one is seen that is none.

namespace kalfem::test {
namespace {

TEST(ParameterJumpSeeds, TimeAndSizeOfADropOfAFifthAtTenSeconds) {
  double latest = 0.0, largest = 0.0, farthest = 0.0;
  for (int seed = 1; seed <= 20; ++seed) {
    const auto estimate = estimate_of(steady_chain(seed, 20.0), dropping_chain(seed, 20.0, 10.0));
    ASSERT_TRUE(estimate.jump.has_value()) << seed;
    const auto& jump = *estimate.jump;
    EXPECT_EQ(jump.unknown, 0) << seed;
    latest = std::max(latest, std::abs(estimate.measurements.time(jump.sample) - 10.0));
    largest = std::max(largest, std::abs(jump.after / jump.before - 0.8));
    farthest = std::max(farthest, std::abs(jump.after - jump.before + 1e3) / jump.deviation);
  }
  std::printf("20 records: time within %.3f s, size within %.2f %%, %.2f deviations\n", latest, 100.0 * largest,
              farthest);
  EXPECT_LT(latest, 0.1);
  EXPECT_LT(largest, 0.03);
  EXPECT_LT(farthest, 4.0);
}

TEST(ParameterJumpSeeds, NoAlarmInAHundredConstantChains) {
  int alarms = 0;
  for (int seed = 1; seed <= 100; ++seed)
    if (estimate_of(steady_chain(seed, 20.0), steady_chain(seed, 20.0)).jump) ++alarms;
  std::printf("%d alarms in 100 records\n", alarms);
  EXPECT_EQ(alarms, 0);
}

}  // namespace
}  // namespace kalfem::test
