// SPDX-License-Identifier: Apache-2.0
#include "kalfem/statistics/band_clusters.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "kalfem/base/random.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

ScoreCluster no_prior(Index parameters) { return {VectorXd::Zero(parameters), MatrixXd::Zero(parameters, parameters)}; }

ScoreCluster cluster(double score, double information) {
  return {VectorXd::Constant(1, score), MatrixXd::Constant(1, 1, information)};
}

// With G clusters of the same information, the variance is that of a mean of G values.
TEST(ClusterCovariance, OfEqualClustersIsThatOfAMean) {
  const auto found = cluster_covariance({cluster(1.0, 2.0), cluster(-3.0, 2.0), cluster(2.0, 2.0)}, no_prior(1));
  EXPECT_NEAR(found.covariance(0, 0), (1.0 + 9.0 + 4.0) / (1.0 - 1.0 / 3.0) / 36.0, 1e-12);
  EXPECT_NEAR(found.expected[0], 1.0 / 6.0, 1e-12);
  EXPECT_NEAR(found.freedom[0], 2.0, 1e-9);
}

TEST(ClusterCovariance, IsTakenAtTheMinimumNextToTheEstimate) {
  const auto at = cluster_covariance({cluster(1.0, 2.0), cluster(-1.0, 2.0)}, no_prior(1));
  const auto beside = cluster_covariance({cluster(7.0, 2.0), cluster(5.0, 2.0)}, no_prior(1));
  EXPECT_NEAR(beside.covariance(0, 0), at.covariance(0, 0), 1e-12);
}

TEST(ClusterCovariance, ExpectsTheSandwichOfTheData) {
  MatrixXd one(2, 2), other(2, 2), third(2, 2), prior(2, 2);
  one << 4.0, 1.0, 1.0, 2.0;
  other << 1.0, -0.5, -0.5, 3.0;
  third << 0.3, 0.0, 0.0, 0.1;
  prior << 0.5, 0.0, 0.0, 0.25;
  const VectorXd zero = VectorXd::Zero(2);
  const auto found = cluster_covariance({{zero, one}, {zero, other}, {zero, third}}, {zero, prior});
  const MatrixXd inverse = (one + other + third + prior).inverse();
  const VectorXd expected = (inverse * (one + other + third) * inverse).diagonal();
  EXPECT_LT((found.expected - expected).norm(), 1e-12);
  EXPECT_GT(found.freedom.minCoeff(), 0.9);
  EXPECT_LT(found.freedom.maxCoeff(), 4.0);
}

TEST(ClusterCovariance, SaysNothingOfWhatOneClusterDecidesAlone) {
  const auto found = cluster_covariance({cluster(3.0, 2.0), cluster(0.0, 0.0)}, no_prior(1));
  EXPECT_EQ(found.covariance(0, 0), 0.0);
  EXPECT_EQ(found.freedom[0], 0.0);
}

/// Two sensors, two parameters, of random numbers, some missing.
SensitiveInnovations random_innovations(Index samples) {
  RandomStream random(3, "bands");
  const auto draw = [&] { return MatrixXd::NullaryExpr(2, samples, [&] { return random.normal(); }).eval(); };
  SensitiveInnovations innovations{draw(), {draw(), draw()}};
  innovations.value(0, 7) = innovations.derivative[0](0, 7) = innovations.derivative[1](0, 7) =
      std::numeric_limits<double>::quiet_NaN();
  return innovations;
}

TEST(BandScores, AddUpToTheScoresOfAllSamples) {
  const auto innovations = random_innovations(157);
  for (const int shift : {0, 1, 2})
    for (const bool by_sensor : {false, true}) {
      VectorXd score = VectorXd::Zero(2);
      MatrixXd information = MatrixXd::Zero(2, 2);
      for (const auto& each : BandScores(innovations).octaves(shift, by_sensor)) {
        score += each.score;
        information += each.information;
      }
      for (Index i = 0; i < 2; ++i) {
        const auto present = [](const MatrixXd& values) { return values.array().isNaN().select(0.0, values).eval(); };
        const MatrixXd d = present(innovations.derivative[static_cast<std::size_t>(i)]);
        EXPECT_NEAR(score[i], -d.cwiseProduct(present(innovations.value)).sum(), 1e-9);
        for (Index j = 0; j < 2; ++j)
          EXPECT_NEAR(information(i, j),
                      d.cwiseProduct(present(innovations.derivative[static_cast<std::size_t>(j)])).sum(), 1e-9);
      }
    }
}

VectorXd sine(double cycles_per_sample, Index samples) {
  return VectorXd::LinSpaced(samples, 0.0, static_cast<double>(samples - 1)).unaryExpr([&](double k) {
    return std::sin(2.0 * std::numbers::pi * cycles_per_sample * k);
  });
}

// Two modes want a parameter to be `wanted` more and less. Their mean is the estimate, and its deviation is `wanted`.
TEST(BandVariances, AreWhatTwoModesContradictEachOtherBy) {
  constexpr Index samples = 8192;
  constexpr double wanted = 3.0;
  const VectorXd low = sine(256.0 / samples, samples), high = sine(2500.0 / samples, samples);
  SensitiveInnovations innovations;
  innovations.value = (-wanted * (low - high)).transpose();
  innovations.derivative = {(low + high).transpose()};
  const VectorXd variances = band_variances(innovations, no_prior(1));
  EXPECT_NEAR(variances[0], wanted * wanted, 1e-6 * wanted * wanted);
}

TEST(BandVariances, AreZeroWhereTheBandsAgree) {
  constexpr Index samples = 4096;
  int widened = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    RandomStream random(seed, "noise");
    SensitiveInnovations innovations;
    innovations.value = MatrixXd::NullaryExpr(1, samples, [&] { return random.normal(); });
    innovations.derivative = {(sine(0.03, samples) + 0.5 * sine(0.2, samples)).transpose()};
    widened += band_variances(innovations, no_prior(1))[0] > 0.0 ? 1 : 0;
  }
  EXPECT_LE(widened, 5);
}

}  // namespace
}  // namespace kalfem
