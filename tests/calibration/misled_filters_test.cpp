// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "calibration_runs.hpp"

// A right model whose first guess misleads the filter while it learns its first samples.

namespace kalfem::calibration {
namespace {

struct Case {
  std::uint64_t seed;
  const char* kind;
};

class SecondPass : public testing::TestWithParam<Case> {};

TEST_P(SecondPass, MendsWhatAFirstGuessFarOffDid) {
  auto given = random_record(GetParam().seed, {.periods = 25.0, .lumped = true});
  ASSERT_NE(given.kind.find(GetParam().kind), std::string::npos) << given.kind;
  given.options.substeps = 8;
  auto once = given.options;
  once.second_thoughts = 0.0;
  EXPECT_NE(estimate(given.structure, given.record, once).verdict.state(), VerdictState::consistent);
  const auto found = estimate(given.structure, given.record, given.options);
  EXPECT_EQ(found.verdict.state(), VerdictState::consistent)
      << codes_of(found.verdict) << " "
      << (found.verdict.reasons().empty() ? "" : found.verdict.reasons().front().text);
  for (std::size_t i = 0; i < given.truth.size(); ++i)
    EXPECT_NEAR(found.parameters[i].mean, given.truth[i], 3.0 * found.parameters[i].std) << found.parameters[i].name;
}

INSTANTIATE_TEST_SUITE_P(OfTrees, SecondPass, testing::Values(Case{50, "tree of 3, gap"}, Case{61, "tree of 2, gap"}));

}  // namespace
}  // namespace kalfem::calibration
