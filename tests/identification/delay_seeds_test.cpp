// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "identification/imperfect_sensors.hpp"
#include "kalfem/identification/record_estimate.hpp"

// A delay over many records.

namespace kalfem::test {
namespace {

// One sensor of four is late by 7.25 samples.
TEST(DelayOverSeeds, LiesInItsIntervalAndWithinATenthOfASample) {
  EstimationProblem problem = chain_problem();
  const auto fine = fine_chain_signals(problem, 6.0);
  problem.settings.likelihood_unknowns = {unknown_delay("a6", 5e-3)};
  constexpr int seeds = 40;
  constexpr double truth = 7.25e-3;
  int covered = 0;
  double largest = 0.0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const auto record = faulty_record(problem, fine, {{}, {}, {.delay = 29}, {}}, static_cast<std::uint64_t>(seed));
    const auto given = shared(problem);
    IssueList issues;
    const auto setup = make_augmented_model_setup(*given, given->structure->parts, {}, issues);
    issues.raise();
    const auto estimate = estimate_record(given, setup, record);
    ASSERT_TRUE(estimate.likelihood && estimate.likelihood->converged) << seed;
    const auto interval = estimate.likelihood->interval(0);
    covered += interval.lower <= truth && truth <= interval.upper ? 1 : 0;
    largest = std::max(largest, std::abs(estimate.likelihood->values[0] - truth) * chain_rate);
  }
  std::printf("delay: %d of %d intervals hold the truth; largest error %.3f samples\n", covered, seeds, largest);
  EXPECT_GE(covered, 36);
  EXPECT_LT(largest, 0.1);
}

}  // namespace
}  // namespace kalfem::test
