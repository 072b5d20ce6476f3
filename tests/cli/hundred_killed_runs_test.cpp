// SPDX-License-Identifier: Apache-2.0
#include "killed_runs.hpp"

namespace kalfem::test {
namespace {

TEST(KilledRuns, AtAHundredMomentsLeaveTheResultsOfOneRun) {
  const auto counts = kill_runs(100);
  EXPECT_EQ(counts.killed, 100);
  EXPECT_GE(counts.took_effect, 1);
  RecordProperty("killed", counts.killed);
  RecordProperty("took_effect", counts.took_effect);
}

}  // namespace
}  // namespace kalfem::test
