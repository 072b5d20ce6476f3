// SPDX-License-Identifier: Apache-2.0
#include "kalfem/statistics/robust_covariance.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <vector>

#include "kalfem/base/random.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// x_k = a x_{k-1} + b x_{k-2} + e_k from its stationary state; the variance of the sum tends to N / (1 - a - b)^2.
VectorXd autoregression(double a, double b, Index samples, std::uint64_t seed) {
  RandomStream random(seed, "autoregression");
  VectorXd series(samples);
  double one = 0.0, two = 0.0;
  for (Index k = -2000; k < samples; ++k) {
    const double next = a * one + b * two + random.normal();
    two = one;
    one = next;
    if (k >= 0) series[k] = next;
  }
  return series;
}

struct Outcome {
  double ratio = 0.0;     // median over seeds of the stated deviation of the sum to the true one
  double coverage = 0.0;  // how often the sum lies within 1.96 stated deviations
};

Outcome outcome_over_seeds(double a, double b, Index samples, int seeds) {
  const double truth = std::sqrt(static_cast<double>(samples)) / (1.0 - a - b);
  std::vector<double> ratios;
  Outcome outcome;
  for (int seed = 1; seed <= seeds; ++seed) {
    const VectorXd series = autoregression(a, b, samples, static_cast<std::uint64_t>(seed));
    // As scores at an estimate: about their mean, which is what the estimate makes of the sum.
    const VectorXd centred = series.array() - series.mean();
    const double stated = std::sqrt(long_run_covariance(centred.transpose()).of_sum(0, 0));
    ratios.push_back(stated / truth);
    outcome.coverage += std::abs(series.sum()) <= 1.96 * stated ? 1.0 / seeds : 0.0;
  }
  std::ranges::nth_element(ratios, ratios.begin() + seeds / 2);
  outcome.ratio = ratios[static_cast<std::size_t>(seeds) / 2];
  return outcome;
}

TEST(LongRunCovariance, OfIndependentSamplesIsTheSumOfTheirProducts) {
  const auto [ratio, coverage] = outcome_over_seeds(0.0, 0.0, 2000, 200);
  EXPECT_NEAR(ratio, 1.0, 0.01);  // found 0.9995
  EXPECT_NEAR(coverage, 0.95, 0.04);
}

// Scores of vibration records sampled many times a period: without their correlation the deviation is a seventh.
TEST(LongRunCovariance, ReachesTheDeviationOfStronglyCorrelatedScores) {
  const auto [ratio, coverage] = outcome_over_seeds(0.96, 0.0, 20000, 200);
  EXPECT_GE(ratio, 0.85);  // found 0.95
  EXPECT_LE(ratio, 1.1);
  EXPECT_GE(coverage, 0.9);
}

TEST(LongRunCovariance, FollowsOscillatingScores) {
  // Poles at radius 0.98 and 0.3 rad per sample: the sum varies less than that of independent samples of this size.
  const auto [ratio, coverage] = outcome_over_seeds(2.0 * 0.98 * std::cos(0.3), -0.98 * 0.98, 20000, 100);
  EXPECT_GE(ratio, 0.9);  // found 0.98
  EXPECT_LE(ratio, 1.1);
  EXPECT_GE(coverage, 0.9);
}

// The first-order model sees the fast part alone: 1 of lag-one correlation 0 beside a slow part of 0.1.
TEST(LongRunCovariance, SeesASlowPartUnderAFastOne) {
  const Index samples = 20000;
  const double slow_deviation = 0.05;
  std::vector<double> ratios;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const VectorXd slow = slow_deviation * autoregression(0.995, 0.0, samples, seed),
                   fast = autoregression(0.0, 0.0, samples, seed + 1000);
    const VectorXd series = slow + fast;
    const auto found = long_run_covariance((series.array() - series.mean()).matrix().transpose());
    const double truth = std::sqrt(static_cast<double>(samples) * (1.0 + std::pow(slow_deviation / 0.005, 2)));
    ratios.push_back(std::sqrt(found.of_sum(0, 0)) / truth);
  }
  std::ranges::nth_element(ratios, ratios.begin() + 20);
  EXPECT_GE(ratios[20], 0.7);
  EXPECT_LE(ratios[20], 1.1);
}

// First-order autoregression with a carrier of 2.3 rad per sample beside a slow one of the same size, as products of
// two narrow-band motions are: scores of a lightly damped mode.
TEST(LongRunCovariance, SeesTheSlowPartOfScoresThatOscillate) {
  const Index samples = 4000;
  std::vector<double> ratios;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const VectorXd slow = autoregression(0.98, 0.0, samples, seed),
                   carrier = autoregression(2.0 * 0.98 * std::cos(2.3), -0.98 * 0.98, samples, seed + 1000);
    const VectorXd series = slow + 2.0 * carrier;
    const auto found = long_run_covariance((series.array() - series.mean()).matrix().transpose());
    ratios.push_back(std::sqrt(found.of_sum(0, 0) / static_cast<double>(samples)) / 50.0);
  }
  std::ranges::nth_element(ratios, ratios.begin() + 50);
  std::cout << "slow part of oscillating scores: stated / true deviation " << ratios[50] << "\n";
  EXPECT_GE(ratios[50], 0.85);
  EXPECT_LE(ratios[50], 1.1);
}

// Nine tenths of the information come from a tenth of the record, whose scores hang together over a third of it.
TEST(LongRunCovariance, MakesUpForTheCentringOfABurst) {
  const Index samples = 5000, burst = 500;
  MatrixXd information = MatrixXd::Constant(1, samples, 0.1 / static_cast<double>(samples - burst));
  information.leftCols(burst).setConstant(0.9 / static_cast<double>(burst));
  double stated = 0.0, without = 0.0, truth = 0.0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const VectorXd series =
        autoregression(0.97, 0.0, samples, seed).cwiseProduct(information.row(0).transpose().cwiseSqrt());
    const VectorXd centred = series - series.sum() * information.row(0).transpose();
    stated += long_run_covariance(centred.transpose(), information).of_sum(0, 0);
    without += long_run_covariance(centred.transpose()).of_sum(0, 0);
    truth += series.sum() * series.sum();
  }
  std::cout << "burst: stated / true variance " << stated / truth << ", with equal shares " << without / truth << "\n";
  EXPECT_GE(stated / truth, 0.7);
  EXPECT_LE(stated / truth, 1.3);
  EXPECT_GE(stated, 1.1 * without);
}

TEST(LongRunCovariance, DoesNotDependOnUnits) {
  MatrixXd series(2, 5000);
  series.row(0) = autoregression(0.9, 0.0, 5000, 1).transpose();
  series.row(1) = 0.5 * series.row(0) + autoregression(0.5, 0.0, 5000, 2).transpose();
  const auto plain = long_run_covariance(series);
  const VectorXd unit = VectorXd{{1e9, 1e-7}};
  const auto scaled = long_run_covariance(unit.asDiagonal() * series);
  EXPECT_TRUE(scaled.of_sum.isApprox(unit.asDiagonal() * plain.of_sum * unit.asDiagonal(), 1e-12));
  EXPECT_NEAR(scaled.bandwidth, plain.bandwidth, 1e-9 * plain.bandwidth);  // rounding of the units
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<MatrixXd>(plain.of_sum).eigenvalues()[0], 0.0);
}

TEST(LongRunCovariance, OfNothingAndOfZerosIsZero) {
  EXPECT_TRUE(long_run_covariance(MatrixXd(3, 0)).of_sum.isZero(0.0));
  EXPECT_TRUE(long_run_covariance(MatrixXd::Zero(2, 500)).of_sum.isZero(0.0));
}

}  // namespace
}  // namespace kalfem
