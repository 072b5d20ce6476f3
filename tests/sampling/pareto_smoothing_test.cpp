// SPDX-License-Identifier: Apache-2.0
#include "kalfem/sampling/pareto_smoothing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "kalfem/base/random.hpp"

namespace kalfem {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Quantiles at (j - 1/2) / n, ascending.
Eigen::VectorXd even_sample(const GeneralisedPareto& distribution, int count) {
  Eigen::VectorXd x(count);
  for (int j = 0; j < count; ++j) x[j] = distribution.quantile((j + 0.5) / count);
  return x;
}

/// ln w of w = u^-k: the excess over any threshold is generalised Pareto with the shape k.
Eigen::VectorXd log_power_weights(double k, int count) {
  Eigen::VectorXd log_weights(count);
  for (int j = 0; j < count; ++j) log_weights[j] = -k * std::log((j + 0.5) / count);
  return log_weights;
}

TEST(ParetoSmoothing, QuantilesInClosedForm) {
  EXPECT_NEAR((GeneralisedPareto{0.5, 1.0}).quantile(0.75), 2.0, 1e-14);  // (0.25^-0.5 - 1) / 0.5
  EXPECT_NEAR((GeneralisedPareto{0.0, 3.0}).quantile(0.75), 3.0 * std::log(4.0), 1e-14);
  EXPECT_NEAR((GeneralisedPareto{1e-9, 3.0}).quantile(0.75), 3.0 * std::log(4.0), 1e-8);
  EXPECT_NEAR((GeneralisedPareto{-1.0, 2.0}).quantile(0.75), 1.5, 1e-14);  // uniform on 0 to 2
}

TEST(ParetoSmoothing, FindsShapeAndScale) {
  for (const double shape : {-0.3, 0.0, 0.3, 0.7, 1.5}) {
    const GeneralisedPareto fit = fit_generalised_pareto(even_sample({shape, 2.0}, 2000));
    EXPECT_NEAR(fit.shape, shape, 0.03);
    EXPECT_NEAR(fit.scale, 2.0, 0.06);
  }
}

TEST(ParetoSmoothing, ShapeOfRandomSamplesHasNoBias) {
  // the deviation of the most likely k is (1 + k) / sqrt(n)
  double sum = 0.0;
  for (int repeat = 0; repeat < 200; ++repeat) {
    RandomStream random(7, "generalised Pareto " + std::to_string(repeat));
    Eigen::VectorXd x(100);
    for (auto& value : x) value = GeneralisedPareto{0.5, 1.0}.quantile(random.uniform());
    std::sort(x.begin(), x.end());
    sum += fit_generalised_pareto(x).shape / 200.0;
  }
  EXPECT_NEAR(sum, 0.5, 3.0 * 1.5 / std::sqrt(100.0 * 200.0));
}

TEST(ParetoSmoothing, FitFollowsTheUnit) {
  const Eigen::VectorXd x = even_sample({0.4, 1.0}, 100);
  const GeneralisedPareto one = fit_generalised_pareto(x), thousand = fit_generalised_pareto(1000.0 * x);
  EXPECT_NEAR(one.shape, thousand.shape, 1e-10);
  EXPECT_NEAR(1000.0 * one.scale, thousand.scale, 1e-7);
}

TEST(ParetoSmoothing, AgreesWithFormulasWrittenOutElsewhere) {
  // computed apart, in the notation of Zhang and Stephens: k of the other sign, theta = k / sigma
  const GeneralisedPareto even = fit_generalised_pareto(Eigen::VectorXd::LinSpaced(10, 0.1, 1.0));
  EXPECT_NEAR(even.shape, -0.7872577745173902, 1e-10);
  EXPECT_NEAR(even.scale, 0.9128092726263269, 1e-10);
  Eigen::VectorXd powers(8);
  powers << 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0;
  EXPECT_NEAR(fit_generalised_pareto(powers).shape, 1.032011119156347, 1e-10);
  EXPECT_NEAR(fit_generalised_pareto(powers).scale, 10.227682957705184, 1e-9);

  const SmoothedWeights heavy = smooth_weights(log_power_weights(0.8, 50));
  EXPECT_NEAR(heavy.k_hat, 0.5796800388090354, 1e-10);
  EXPECT_NEAR(heavy.log_weights[0], 3.39530033612455, 1e-10);
  EXPECT_NEAR(heavy.log_weights[9], 1.2961246064199323, 1e-10);

  Eigen::VectorXd light = log_power_weights(0.3, 50);
  light[0] = light[1] + 0.01;  // the two largest would be above the largest one
  const SmoothedWeights cut = smooth_weights(light);
  EXPECT_NEAR(cut.k_hat, 0.17772831727269717, 1e-10);
  EXPECT_EQ(cut.log_weights[0], light[0]);
  EXPECT_EQ(cut.log_weights[1], light[0]);
  EXPECT_NEAR(cut.log_weights[2], 0.9393392268204417, 1e-10);
}

TEST(ParetoSmoothing, KHatOfPowerLawWeights) {
  constexpr int count = 10000, tail = 300;  // 3 sqrt(count)
  for (const double k : {0.2, 0.5, 0.7, 1.0, 2.0})
    EXPECT_NEAR(smooth_weights(log_power_weights(k, count)).k_hat, (tail * k + 5.0) / (tail + 10.0), 0.06) << k;
}

TEST(ParetoSmoothing, LeavesThePowerLawAndTheRestOfTheWeights) {
  const Eigen::VectorXd raw = log_power_weights(0.6, 10000);
  const SmoothedWeights smoothed = smooth_weights(raw);
  EXPECT_EQ(smoothed.log_weights.tail(10000 - 300), raw.tail(10000 - 300));  // of the tail: the first 300
  for (int j = 0; j < 300; ++j) EXPECT_NEAR(smoothed.log_weights[j], raw[j], j < 10 ? 0.2 : 0.05) << j;
  for (int j = 1; j < 300; ++j) EXPECT_LE(smoothed.log_weights[j], smoothed.log_weights[j - 1]);
}

TEST(ParetoSmoothing, TamesOneHugeWeight) {
  Eigen::VectorXd raw = log_power_weights(0.3, 1000);
  raw[500] = 20.0;
  const SmoothedWeights smoothed = smooth_weights(raw);
  EXPECT_GT(smoothed.k_hat, k_hat_limit(1000));
  EXPECT_LE(smoothed.log_weights.maxCoeff(), 20.0);
  EXPECT_EQ(smoothed.log_weights[500], smoothed.log_weights.maxCoeff());  // the order stays
}

TEST(ParetoSmoothing, DoesNotDependOnTheLikelihoodsConstant) {
  const Eigen::VectorXd raw = log_power_weights(0.6, 1000);
  const SmoothedWeights here = smooth_weights(raw), below = smooth_weights((raw.array() - 1e6).matrix());
  EXPECT_NEAR(here.k_hat, below.k_hat, 1e-6);
  EXPECT_LT((here.log_weights - below.log_weights - Eigen::VectorXd::Constant(1000, 1e6)).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(ParetoSmoothing, SaysWhereThereIsNoTail) {
  EXPECT_EQ(smooth_weights(Eigen::VectorXd::Constant(100, 3.0)).k_hat, 0.0);
  EXPECT_EQ(smooth_weights(Eigen::VectorXd::Zero(10)).k_hat, infinity);  // too few
  EXPECT_EQ(smooth_weights(Eigen::VectorXd::Constant(100, -infinity)).k_hat, infinity);
  Eigen::VectorXd four = Eigen::VectorXd::Constant(100, -infinity);
  four.head(4) << 1.0, 2.0, 3.0, 4.0;
  EXPECT_EQ(smooth_weights(four).k_hat, infinity);
  EXPECT_EQ(smooth_weights(four).log_weights, four);
}

TEST(ParetoSmoothing, LimitGrowsWithTheNumberOfSamples) {
  EXPECT_NEAR(k_hat_limit(100), 0.5, 1e-12);
  EXPECT_NEAR(k_hat_limit(1000), 2.0 / 3.0, 1e-12);
  EXPECT_EQ(k_hat_limit(1000000), 0.7);
}

}  // namespace
}  // namespace kalfem
