// SPDX-License-Identifier: Apache-2.0
#include <iostream>

#include "casefile/blow_trials.hpp"

// Damping from records of ten blows, and of white forces, over 200 random chains each; KALFEM_SEEDS changes the number.

namespace kalfem::test {
namespace {

int seeds() {
  const char* given = std::getenv("KALFEM_SEEDS");
  return given ? std::max(1, std::atoi(given)) : 200;
}

/// Interval of a binomial count of probability .95 that holds 99 % of it: normal, with the correction for continuity.
bool is_95_per_cent(int count, int of) { return std::abs(count - 0.95 * of) <= 2.576 * std::sqrt(0.0475 * of) + 0.5; }

void expect_damping(BlowTest::Force force, const char* what) {
  const ScratchFolder folder("blow-records");
  int covered = 0, consistent = 0;
  double width = 0.0, shift = 0.0;
  for (int seed = 1; seed <= seeds(); ++seed) {
    const DampingTrial trial = damping_trial(force, static_cast<std::uint64_t>(seed), folder);
    covered += trial.covered() ? 1 : 0;
    consistent += trial.consistent ? 1 : 0;
    width += trial.half_width() / seeds();
    shift += (trial.found / trial.truth - 1.0) / seeds();
    if (!trial.covered() || !trial.consistent)
      std::cout << "seed " << seed << ": " << trial.found << " [" << trial.lower << ", " << trial.upper << "] for "
                << trial.truth << ": " << trial.words << std::endl;
  }
  std::cout << what << ": truth in its interval " << covered << " of " << seeds() << ", mean half-width "
            << 100.0 * width << " %, mean error " << 100.0 * shift << " %, consistent " << consistent << std::endl;
  EXPECT_TRUE(is_95_per_cent(covered, seeds())) << covered;
  EXPECT_LT(width, 0.08);
  EXPECT_GE(consistent, 0.94 * seeds());
}

TEST(BlowRecordSeeds, DampingFromTenBlowsIsInItsInterval) { expect_damping(BlowTest::Force::blows, "blows"); }

TEST(BlowRecordSeeds, DampingFromAWhiteForceIsInItsInterval) { expect_damping(BlowTest::Force::white, "white"); }

}  // namespace
}  // namespace kalfem::test
