// SPDX-License-Identifier: Apache-2.0
#include "killed_runs.hpp"

namespace kalfem::test {
namespace {

TEST(KilledRuns, LeaveTheResultsOfOneRun) {
  const auto counts = kill_runs(12);
  EXPECT_EQ(counts.killed, 12);
}

}  // namespace
}  // namespace kalfem::test
