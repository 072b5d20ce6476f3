// SPDX-License-Identifier: Apache-2.0
#include "kalfem/sampling/prior.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace kalfem {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

const std::vector<MarginalPrior> marginals = {NormalPrior{2.0, 3.0},
                                              NormalPrior{2.0, 3.0, 1.0, infinity},
                                              NormalPrior{0.0, 1.0, 8.0, 9.0},  // in the far tail
                                              NormalPrior{0.0, 1.0, -20.0, -19.0},
                                              LogNormalPrior{2.0, 0.5},
                                              LogNormalPrior{2.0, 0.5, 1.0, 3.0},
                                              UniformPrior{-1.0, 4.0}};

/// Simpson's rule over all that matters.
template <class Function>
double integral(const MarginalPrior& marginal, const Function& g) {
  const double lower = from_normal(marginal, -8.5), upper = from_normal(marginal, 8.5);
  constexpr int pieces = 20000;
  const double h = (upper - lower) / pieces;
  double sum = 0.0;
  for (int k = 0; k <= pieces; ++k) {
    const double x = std::min(lower + k * h, upper);
    sum += (k == 0 || k == pieces ? 1.0 : k % 2 == 1 ? 4.0 : 2.0) * g(x) * std::exp(log_density(marginal, x));
  }
  return sum * h / 3.0;
}

TEST(Prior, IsNormalisedAndHasTheMomentsOfItsDensity) {
  for (const auto& marginal : marginals) {
    const double m = mean(marginal);
    EXPECT_NEAR(integral(marginal, [](double) { return 1.0; }), 1.0, 1e-6);
    EXPECT_NEAR(integral(marginal, [](double x) { return x; }), m, 1e-6 * std::abs(m));
    EXPECT_NEAR(std::sqrt(integral(marginal, [&](double x) { return (x - m) * (x - m); })), deviation(marginal),
                1e-5 * deviation(marginal));
  }
}

TEST(Prior, NormalScoresGoThereAndBack) {
  for (const auto& marginal : marginals)
    for (const double w : {-7.0, -3.0, -0.1, 0.0, 1.0, 4.0, 7.0}) {
      const double x = from_normal(marginal, w);
      const auto [lower, upper] = support(marginal);
      EXPECT_GE(x, lower);
      EXPECT_LE(x, upper);
      // x cannot tell scores apart whose values differ by less than rounding: near a bound away from zero
      const double slope = std::abs(from_normal(marginal, w + 1e-4) - from_normal(marginal, w - 1e-4)) / 2e-4;
      EXPECT_NEAR(to_normal(marginal, x), w, 1e-8 + 1e-14 * std::abs(x) / std::max(slope, 1e-300)) << marginal.index();
    }
}

TEST(Prior, NormalScoreIsTheProbability) {
  // d x / d w = phi(w) / p(x)
  for (const auto& marginal : marginals)
    for (const double w : {-2.0, 0.0, 1.5}) {
      const double slope = (from_normal(marginal, w + 1e-4) - from_normal(marginal, w - 1e-4)) / 2e-4;
      const double density = std::exp(-0.5 * w * w) / std::sqrt(2.0 * std::numbers::pi);
      EXPECT_NEAR(slope * std::exp(log_density(marginal, from_normal(marginal, w))), density, 1e-6);
    }
}

TEST(Prior, NarrowBoundsKeepTheirMass) {
  const NormalPrior narrow{0.0, 1.0, 1.0, 1.0 + 1e-9};
  EXPECT_NEAR(log_density(narrow, 1.0 + 5e-10), std::log(1e9), 1e-6);
}

TEST(Prior, IsImpossibleOutside) {
  EXPECT_EQ(log_density(UniformPrior{0.0, 1.0}, 1.1), -infinity);
  EXPECT_EQ(log_density(LogNormalPrior{}, -1.0), -infinity);
  EXPECT_EQ(log_density(NormalPrior{}, std::nan("")), -infinity);
}

TEST(Prior, CorrelatedNormalsAreAMultivariateNormal) {
  Eigen::Matrix2d r;
  r << 1.0, 0.8, 0.8, 1.0;
  const JointPrior prior({{"a", NormalPrior{1.0, 2.0}}, {"b", NormalPrior{-1.0, 0.5}}}, r);
  const Eigen::Vector2d theta(2.5, -0.7);
  const Eigen::Vector2d score((theta[0] - 1.0) / 2.0, (theta[1] + 1.0) / 0.5);
  const double expected = -0.5 * score.dot(r.inverse() * score) - 0.5 * std::log(r.determinant()) -
                          std::log(2.0 * std::numbers::pi) - std::log(2.0 * 0.5);
  EXPECT_NEAR(prior.log_density(theta), expected, 1e-12);
  EXPECT_TRUE(prior.from_standard_normal(prior.to_standard_normal(theta)).isApprox(theta, 1e-12));
}

TEST(Prior, SamplesHaveItsMomentsAndCorrelation) {
  Eigen::Matrix2d r;
  r << 1.0, -0.6, -0.6, 1.0;
  const JointPrior prior({{"a", NormalPrior{1.0, 2.0}}, {"b", NormalPrior{5.0, 0.5}}}, r);
  RandomStream random(3, "prior");
  constexpr int count = 20000;
  Eigen::MatrixXd samples(2, count);
  for (int k = 0; k < count; ++k) samples.col(k) = prior.sample(random);
  const Eigen::Vector2d m = samples.rowwise().mean();
  const Eigen::MatrixXd centred = samples.colwise() - m;
  const Eigen::Matrix2d covariance = centred * centred.transpose() / count;
  EXPECT_NEAR(m[0], 1.0, 4.0 * 2.0 / std::sqrt(count));  // four standard errors
  EXPECT_NEAR(m[1], 5.0, 4.0 * 0.5 / std::sqrt(count));
  EXPECT_NEAR(covariance(0, 1) / std::sqrt(covariance(0, 0) * covariance(1, 1)), -0.6, 4.0 * 0.64 / std::sqrt(count));
}

std::string complaint(const Named<MarginalPrior>& given, const Eigen::MatrixXd& of_scores = {}) {
  const IssueList issues = validate(given, of_scores);
  return issues.issues().size() == 1 ? to_string(issues.issues()[0])
                                     : std::to_string(issues.issues().size()) + " issues";
}

TEST(Prior, SaysWhatIsWrong) {
  const auto contains = [](const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  contains(complaint({{"k", NormalPrior{1.0, 0.0}}}), "k: deviation 0: it must be > 0");
  contains(complaint({{"k", UniformPrior{2.0, 1.0}}}), "lower one must be less");
  contains(complaint({{"k", UniformPrior{0.0, infinity}}}), "improper");
  contains(complaint({{"k", NormalPrior{0.0, 1.0, 40.0, 41.0}}}), "no probability between the bounds");
  contains(complaint({{"k", LogNormalPrior{-1.0, 1.0}}}), "median -1");
  contains(complaint({{"k", LogNormalPrior{1.0, 1.0, -1.0, 2.0}}}), "log-normal parameter is positive");
  contains(complaint({}), "without parameters");
  EXPECT_THROW(JointPrior({{"k", UniformPrior{0.0, infinity}}}), InvalidInput);  // so no evidence of it can be asked
  Eigen::Matrix3d r;
  r << 1.0, 0.9, -0.9, 0.9, 1.0, 0.9, -0.9, 0.9, 1.0;
  const Named<MarginalPrior> three = {{"a", NormalPrior{}}, {"b", NormalPrior{}}, {"c", NormalPrior{}}};
  contains(complaint(three, r), "not positive definite");
  contains(complaint(three, Eigen::Matrix2d::Identity()), "2 x 2");
  EXPECT_THROW(JointPrior(three, r), InvalidInput);
}

}  // namespace
}  // namespace kalfem
