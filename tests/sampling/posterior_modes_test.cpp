// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "kalfem/sampling/importance_sampler.hpp"
#include "kalfem/sampling/laplace.hpp"
#include "kalfem/sampling/peak_search.hpp"
#include "posterior_problems.hpp"

namespace kalfem {
namespace {

constexpr long long searches = 4000;

/// A problem of the kind with both weights above a twentieth.
template <class Make>
std::pair<PosteriorProblem, Quadrature> drawn(Make make, std::uint64_t seed) {
  for (std::uint64_t attempt = 0;; ++attempt) {
    RandomStream random(100 * seed + attempt, "posterior modes");
    auto problem = make(random);
    const Quadrature exact = quadrature(problem);
    if (exact.first_weight > 0.05 && exact.first_weight < 0.95) return {std::move(problem), exact};
  }
}

template <class Mode, class Weight>
double first_weight(const PosteriorProblem& problem, const std::vector<Mode>& modes, Weight weight) {
  double sum = 0.0;
  for (const auto& mode : modes) sum += problem.first_side(mode.peak) ? weight(mode) : 0.0;
  return sum;
}

class PosteriorModes : public testing::TestWithParam<PosteriorProblem (*)(RandomStream&)> {};

TEST_P(PosteriorModes, BothAreFoundWithTheirWeights) {
  const auto [problem, exact] = drawn(GetParam(), 1);
  const ImportanceResult result = sample_importance(problem.posterior, {.search_likelihoods = searches});
  ASSERT_EQ(result.modes.size(), 2u) << problem.name;
  EXPECT_GE(result.prior_starts, 60);
  EXPECT_TRUE(result.warnings.empty()) << result.warnings.front();
  EXPECT_NEAR(first_weight(problem, result.modes, [](const PosteriorMode& mode) { return mode.weight; }),
              exact.first_weight, 0.05);
  EXPECT_NEAR(result.log_evidence, exact.log_evidence, 4.0 * result.log_evidence_deviation);

  const auto laplace = laplace_approximation(problem.posterior, {.search_likelihoods = searches});
  ASSERT_EQ(laplace.others.size(), 1u);
  EXPECT_NEAR(*laplace.log_evidence_of_all(), exact.log_evidence, 0.2);
}

INSTANTIATE_TEST_SUITE_P(Kinds, PosteriorModes, testing::Values(&series_problem, &symmetric_problem, &sign_problem));

TEST(PosteriorModes, OneIsNotTakenForSeveral) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    RandomStream random(seed, "one mode");
    const auto problem = one_mode_problem(random);
    const ImportanceResult result = sample_importance(problem.posterior, {.search_likelihoods = searches});
    EXPECT_EQ(result.modes.size(), 1u) << problem.name;
    EXPECT_TRUE(result.warnings.empty()) << problem.name << ": " << result.warnings.front();
  }
}

TEST(PosteriorModes, BoundOfWhatWasMissedIsTheChanceOfMissingIt) {
  EXPECT_EQ(unseen_share(0), 1.0);
  for (const int starts : {1, 10, 60}) EXPECT_NEAR(std::pow(1.0 - unseen_share(starts), starts), 0.05, 1e-12);
}

// A second mode to which 3 % of the prior leads is missed by one start; searching on finds it.
TEST(PosteriorModes, SearchGoesOnUntilNothingIsNew) {
  const auto likelihood = [](const Eigen::VectorXd& x) {
    return std::max(log_normal(x[0], 0.0, 0.1), log_normal(x[0], 2.5, 0.02) + 2.0);
  };
  const Posterior posterior{JointPrior({{"a", NormalPrior{0.0, 1.0}}}), likelihood};
  EXPECT_EQ(sample_importance(posterior, {.prior_share = 0.0}).modes.size(), 1u);
  const auto all = sample_importance(posterior, {.search_likelihoods = searches});
  EXPECT_EQ(all.modes.size(), 2u);
  EXPECT_GT(all.prior_starts, 60);
}

}  // namespace
}  // namespace kalfem
