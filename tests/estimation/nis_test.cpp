// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "kalfem/base/random.hpp"
#include "kalfem/estimation/consistency.hpp"
#include "kalfem/estimation/filter.hpp"
#include "kalfem/statistics/quantiles.hpp"

// The tests that judge a filter must be able to fail. Gaussian innovations of a covariance S that is correlated and
// badly scaled have a NIS that is chi-squared with as many degrees of freedom as channels; with S in place of its
// inverse, an unsquared value or other degrees of freedom it is not.

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index samples = 20000;

MatrixXd badly_scaled_covariance() {
  const Eigen::Vector3d scale(1e-3, 1.0, 1e4);
  Eigen::Matrix3d correlation;
  correlation << 1.0, 0.9, -0.5, 0.9, 1.0, -0.3, -0.5, -0.3, 1.0;
  return scale.asDiagonal() * correlation * scale.asDiagonal();
}

struct Scored {
  VectorXd nis{samples}, log_likelihood{samples};
  Eigen::VectorXi measured{samples};
  MatrixXd innovation = MatrixXd::Constant(3, samples, std::numeric_limits<double>::quiet_NaN());
};

/// Every fifth sample lacks the last channel.
Scored scored() {
  const MatrixXd covariance = badly_scaled_covariance();
  RandomStream random(3, "nis");
  Scored all;
  for (Index k = 0; k < samples; ++k) {
    const Index l = k % 5 == 0 ? 2 : 3;
    const MatrixXd factor = covariance.topLeftCorner(l, l).llt().matrixL();
    const VectorXd normal = VectorXd::NullaryExpr(l, [&](Index) { return random.normal(); });
    Innovation innovation{.channels = {}, .value = factor * normal, .covariance = covariance.topLeftCorner(l, l)};
    VectorXd whitened = innovation.value;
    whiten(factor, whitened);
    score(innovation, factor, whitened);
    all.nis[k] = innovation.nis;
    all.log_likelihood[k] = innovation.log_likelihood;
    all.measured[k] = static_cast<int>(l);
    all.innovation.col(k).head(l) = innovation.value;
  }
  return all;
}

/// Mean, variance and fraction beyond the 95 % limit, within four standard deviations of chi-squared.
bool is_chi_squared(const VectorXd& nis, double degrees) {
  const auto n = static_cast<double>(nis.size());
  const double mean = nis.mean(), variance = (nis.array() - mean).square().sum() / n;
  const double beyond = (nis.array() > chi_squared_quantile(0.95, degrees)).cast<double>().sum() / n;
  return std::abs(mean - degrees) < 4.0 * std::sqrt(2.0 * degrees / n) &&
         std::abs(variance / (2.0 * degrees) - 1.0) < 4.0 * std::sqrt((2.0 + 12.0 / degrees) / n) &&
         std::abs(beyond - 0.05) < 4.0 * std::sqrt(0.05 * 0.95 / n);
}

VectorXd of_full_samples(const VectorXd& values) {
  std::vector<double> kept;
  for (Index k = 0; k < samples; ++k)
    if (k % 5 != 0) kept.push_back(values[k]);
  return VectorXd::Map(kept.data(), static_cast<Index>(kept.size()));
}

TEST(Nis, IsChiSquaredWithTheChannelsAsDegreesOfFreedom) {
  const VectorXd nis = of_full_samples(scored().nis);
  EXPECT_TRUE(is_chi_squared(nis, 3.0)) << nis.mean();
}

TEST(Nis, FailsTheTestWithEachMistakeOfPublicPrograms) {
  const auto all = scored();
  const VectorXd nis = of_full_samples(all.nis);
  EXPECT_FALSE(is_chi_squared(nis, 2.0));
  EXPECT_FALSE(is_chi_squared(nis, 4.0));
  EXPECT_FALSE(is_chi_squared(nis.cwiseSqrt(), 3.0));
  const MatrixXd covariance = badly_scaled_covariance();
  VectorXd with_covariance(samples);
  for (Index k = 0; k < samples; ++k)
    with_covariance[k] = k % 5 == 0 ? 0.0 : all.innovation.col(k).dot(covariance * all.innovation.col(k));
  EXPECT_FALSE(is_chi_squared(of_full_samples(with_covariance), 3.0));
}

TEST(Nis, LogLikelihoodIsTheDensityOfTheInnovations) {
  const VectorXd mean = of_full_samples(scored().log_likelihood);
  const double determinant = badly_scaled_covariance().determinant();
  EXPECT_NEAR(mean.mean(), -0.5 * (3.0 + std::log(determinant) + 3.0 * std::log(2.0 * std::numbers::pi)), 0.04);
}

TEST(Nis, ConsistencyCountsTheChannelsOfEachSample) {
  const auto all = scored();
  const VectorXd noise = badly_scaled_covariance().diagonal().cwiseSqrt();
  const auto summary = summarise_consistency(all.nis, all.measured, all.innovation, noise, 0);
  EXPECT_NEAR(summary.expected_nis, 2.8, 1e-12);
  EXPECT_NEAR(summary.mean_nis, 2.8, 0.07);  // four deviations
  EXPECT_NEAR(summary.fraction_in_95, 0.95, 0.0062);
  EXPECT_LT((summary.innovation_to_noise.array() - 1.0).abs().maxCoeff(), 0.025);
}

TEST(Nis, WithoutSamplesThereIsNoFigure) {
  const VectorXd none = VectorXd::Constant(4, std::numeric_limits<double>::quiet_NaN());
  const auto summary = summarise_consistency(none, Eigen::VectorXi::Zero(4), none.transpose(), VectorXd::Ones(1), 0);
  EXPECT_TRUE(std::isnan(summary.mean_nis));
  EXPECT_TRUE(std::isnan(summary.expected_nis));
  EXPECT_TRUE(std::isnan(summary.fraction_in_95));
  EXPECT_TRUE(std::isnan(summary.innovation_to_noise[0]));
}

}  // namespace
}  // namespace kalfem
