#include "killed_runs.hpp"

namespace kalfem::test {
namespace {

TEST(KilledRuns, LeaveTheResultsOfOneRun) {
  const auto counts = kill_runs(12);
  EXPECT_GE(counts.killed, 6);
}

}  // namespace
}  // namespace kalfem::test
