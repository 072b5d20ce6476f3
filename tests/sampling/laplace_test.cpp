// SPDX-License-Identifier: Apache-2.0
#include "kalfem/sampling/laplace.hpp"

#include <gtest/gtest.h>

#include <cstdio>

#include "evidence_cases.hpp"
#include "linear_gaussian.hpp"

namespace kalfem {
namespace {

TEST(Laplace, IsExactOnLinearGaussianProblems) {
  for (const int p : {1, 2, 5, 10}) {
    const EvidenceCase known = linear_gaussian_case(p);
    const LaplaceApproximation result = laplace_approximation(known.posterior);
    ASSERT_TRUE(result.usable()) << p;
    EXPECT_NEAR(*result.log_evidence, known.log_evidence, 1e-5);
    for (Eigen::Index i = 0; i < p; ++i) {
      EXPECT_NEAR(result.mode[i], known.mean[i], 2e-3 * known.deviation[i]);  // the decrement that ends the search
      EXPECT_NEAR(std::sqrt(result.covariance(i, i)), known.deviation[i], 1e-5 * known.deviation[i]);
    }
  }
}

TEST(Laplace, IsNearOnModalData) {
  for (const auto& known : {yuen_case(), frame_case()}) {
    const LaplaceApproximation result = laplace_approximation(known.posterior, {.random_starts = 3});
    ASSERT_TRUE(result.usable()) << (result.warnings.empty() ? "" : result.warnings[0]);
    std::printf("%s: ln Z %.4f (exact %.4f), %d evaluations\n", known.name.c_str(), *result.log_evidence,
                known.log_evidence, result.evaluations);
    EXPECT_NEAR(*result.log_evidence, known.log_evidence, 0.1);
    for (Eigen::Index i = 0; i < 2; ++i) {
      EXPECT_NEAR(result.mode[i], known.mean[i], 0.3 * known.deviation[i]);
      EXPECT_NEAR(std::sqrt(result.covariance(i, i)), known.deviation[i], 0.1 * known.deviation[i]);
    }
  }
}

TEST(Laplace, FindsPosteriorsAThousandTimesNarrowerThanThePriorUnderLargeLikelihoods) {
  const Posterior posterior{
      JointPrior({{"a", NormalPrior{0.0, 1.0}}, {"b", LogNormalPrior{100.0, 1.0}}}),
      [](const Eigen::VectorXd& x) { return log_normal(x[0], 0.7, 1e-3) + log_normal(x[1], 180.0, 0.2) - 1e6; }};
  const LaplaceApproximation result = laplace_approximation(posterior);
  ASSERT_TRUE(result.usable());
  EXPECT_NEAR(result.mode[0], 0.7, 1e-4);
  EXPECT_NEAR(std::sqrt(result.covariance(0, 0)), 1e-3, 1e-6);
  EXPECT_NEAR(std::sqrt(result.covariance(1, 1)), 0.2, 2e-4);
}

bool warns(const LaplaceApproximation& result, const std::string& part) {
  for (const auto& warning : result.warnings)
    if (warning.find(part) != std::string::npos) return true;
  return false;
}

TEST(Laplace, SaysWhereItCannotHold) {
  const Posterior on_bound{uniform_box(1, 0.0, 1.0), [](const Eigen::VectorXd& x) { return 30.0 * x[0]; }};
  EXPECT_TRUE(warns(laplace_approximation(on_bound), "lies on the bound 1"));
  EXPECT_FALSE(laplace_approximation(on_bound).usable());

  const Posterior undetermined{uniform_box(2, 0.0, 1.0),
                               [](const Eigen::VectorXd& x) { return log_normal(x[0] + x[1], 1.0, 0.01); }};
  EXPECT_TRUE(warns(laplace_approximation(undetermined), "not determined by the data"));

  const Posterior cut{uniform_box(1, 0.0, 1.0), [](const Eigen::VectorXd& x) { return log_normal(x[0], 0.1, 0.1); }};
  EXPECT_TRUE(warns(laplace_approximation(cut), "within two deviations"));

  const Posterior nowhere{uniform_box(1, 0.0, 1.0), [](const Eigen::VectorXd&) { return std::nan(""); }};
  EXPECT_THROW(laplace_approximation(nowhere), InvalidInput);
}

TEST(Laplace, NamesTheOtherMaximaWithTheirShares) {
  const EvidenceCase known = blobs_case();
  const auto one = laplace_approximation(known.posterior);
  EXPECT_EQ(one.prior_starts, 0);
  const auto all = laplace_approximation(known.posterior, {.search_likelihoods = 4000});
  ASSERT_EQ(all.others.size(), 1u);
  EXPECT_FALSE(all.usable());
  EXPECT_GE(all.prior_starts, 60);
  EXPECT_NEAR(*all.log_evidence_of_all(), known.log_evidence, 0.05);
  EXPECT_LT(*all.log_evidence, known.log_evidence - 0.1);
}

TEST(Laplace, DoesNotDependOnThreads) {
  const auto one = laplace_approximation(yuen_case().posterior),
             three = laplace_approximation(yuen_case().posterior, {.threads = 3});
  EXPECT_EQ(one.mode, three.mode);
  EXPECT_EQ(one.covariance, three.covariance);
}

}  // namespace
}  // namespace kalfem
