// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstdio>

#include "kalfem/sampling/importance_sampler.hpp"
#include "posterior_problems.hpp"

namespace kalfem {
namespace {

constexpr int problems = 40;
constexpr long long searches = 4000;

TEST(PosteriorModesSeeds, BothOfTwoAreFoundWithTheirWeights) {
  int found = 0, silent = 0;
  std::uint64_t seed = 1;
  for (int made = 0; made < problems; ++seed) {
    RandomStream random(seed, "two modes");
    const auto problem = two_mode_problem(random);
    const Quadrature exact = quadrature(problem);
    if (exact.first_weight < 0.05 || exact.first_weight > 0.95) continue;
    ++made;
    const auto result = sample_importance(problem.posterior, {.search_likelihoods = searches, .seed = seed});
    double first = 0.0;
    bool sides[2] = {false, false};
    for (const auto& mode : result.modes) {
      const bool side = problem.first_side(mode.peak);
      sides[side ? 0 : 1] = true;
      if (side) first += mode.weight;
    }
    const bool right = sides[0] && sides[1] && std::abs(first - exact.first_weight) < 0.1;
    found += right ? 1 : 0;
    silent += !right && result.warnings.empty() ? 1 : 0;
    if (!right || result.modes.size() != 2)
      std::printf("seed %d, %s: %zu modes, weight %.3f (exact %.3f), ln Z %.3f (exact %.3f), %d starts, %zu warnings\n",
                  static_cast<int>(seed), problem.name.c_str(), result.modes.size(), first, exact.first_weight,
                  result.log_evidence, exact.log_evidence, result.prior_starts, result.warnings.size());
  }
  std::printf("two modes: both with their weights in %d of %d; without a word in %d\n", found, problems, silent);
  EXPECT_GE(found, 36);
  EXPECT_LE(silent, 1);
}

TEST(PosteriorModesSeeds, OneModeIsNoReasonForAWarning) {
  int quiet = 0;
  for (std::uint64_t seed = 1; seed <= problems; ++seed) {
    RandomStream random(seed, "one mode");
    const auto problem = one_mode_problem(random);
    const auto result = sample_importance(problem.posterior, {.search_likelihoods = searches, .seed = seed});
    const bool right = result.modes.size() == 1 && result.warnings.empty() &&
                       std::abs(result.log_evidence - quadrature(problem).log_evidence) < 0.2;
    quiet += right ? 1 : 0;
    if (!right)
      std::printf("seed %d, %s: %zu modes, ln Z %.3f (exact %.3f) %s\n", static_cast<int>(seed), problem.name.c_str(),
                  result.modes.size(), result.log_evidence, quadrature(problem).log_evidence,
                  result.warnings.empty() ? "" : result.warnings.front().c_str());
  }
  std::printf("one mode: %d of %d without a warning\n", quiet, problems);
  EXPECT_GE(quiet, 38);
}

}  // namespace
}  // namespace kalfem
