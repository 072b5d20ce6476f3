// SPDX-License-Identifier: Apache-2.0
#include "base/absent.hpp"

#include <gtest/gtest-spi.h>

namespace kalfem {
namespace {

void needs_what_is_absent() { KALFEM_ABSENT("no such data"); }

/// What KALFEM_ABSENT does with CI set to a value, or unset.
testing::TestPartResult outcome_with(const char* value) {
  const char* before = std::getenv("CI");
  const std::string kept = before ? before : "";
  value ? setenv("CI", value, 1) : unsetenv("CI");
  testing::TestPartResultArray results;
  {
    const testing::ScopedFakeTestPartResultReporter reporter(
        testing::ScopedFakeTestPartResultReporter::INTERCEPT_ONLY_CURRENT_THREAD, &results);
    needs_what_is_absent();
  }
  before ? setenv("CI", kept.c_str(), 1) : unsetenv("CI");
  return results.GetTestPartResult(0);
}

TEST(Absent, FailsInContinuousIntegrationAndSkipsElsewhere) {
  EXPECT_TRUE(outcome_with("true").fatally_failed());
  EXPECT_TRUE(outcome_with(nullptr).skipped());
  EXPECT_TRUE(outcome_with("false").skipped());
  EXPECT_NE(std::string(outcome_with(nullptr).message()).find("no such data"), std::string::npos);
}

}  // namespace
}  // namespace kalfem
