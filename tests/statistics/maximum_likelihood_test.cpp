// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "kalfem/base/random.hpp"
#include "kalfem/statistics/maximum_likelihood.hpp"

// The search for a maximum of a likelihood, against closed forms.

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr Index samples = 400;

VectorXd normal_series() {
  RandomStream random(3, "series");
  VectorXd series(samples);
  for (Index k = 0; k < samples; ++k) series[k] = 2.0 + 0.5 * random.normal();
  return series;
}

/// psi = [mean; ln deviation] of a normal distribution.
LogDensities normal_densities(const VectorXd& series) {
  return [series](const VectorXd& psi) -> std::optional<VectorXd> {
    const double deviation = std::exp(psi[1]);
    return VectorXd(-0.5 * ((series.array() - psi[0]) / deviation).square() - psi[1] - 0.5 * std::log(2.0 * M_PI));
  };
}

TEST(MaximumLikelihood, OfANormalDistributionIsItsMeanAndDeviation) {
  const VectorXd series = normal_series();
  const double mean = series.mean(), variance = (series.array() - mean).square().mean();
  const auto found = maximise_likelihood(normal_densities(series), {{.start = 0.0}, {.start = 1.0}});
  ASSERT_TRUE(found && found->converged);
  // The search may stop where 1e-4 of log-likelihood is left: 0.014 standard deviations.
  EXPECT_NEAR(found->estimate[0], mean, 0.014 * std::sqrt(variance / samples));
  EXPECT_NEAR(found->estimate[1], 0.5 * std::log(variance), 0.014 * std::sqrt(0.5 / samples));
  EXPECT_NEAR(found->covariance(0, 0) * samples / variance, 1.0, 1e-3);
  EXPECT_NEAR(found->covariance(1, 1) * samples / 0.5, 1.0, 1e-3);
  EXPECT_NEAR(found->covariance(0, 1), 0.0, 1e-3 * variance / samples);
  EXPECT_NEAR(found->robust.covariance(0, 0) * samples / variance, 1.0, 0.2);
}

TEST(MaximumLikelihood, WeighsThePriorByItsDeviation) {
  const VectorXd series = normal_series();
  const auto densities = [&](const VectorXd& psi) {
    return normal_densities(series)(VectorXd{{psi[0], std::log(0.5)}});
  };
  const double prior = 0.01;
  const auto found = maximise_likelihood(densities, {{.start = 1.0, .prior_mean = 1.0, .prior_deviation = prior}});
  ASSERT_TRUE(found && found->converged);
  const double data = samples / 0.25, own = 1.0 / (prior * prior);
  EXPECT_NEAR(found->estimate[0], (series.mean() * data + own) / (data + own), 2e-4);
  EXPECT_NEAR(found->covariance(0, 0), 1.0 / (data + own), 1e-6 / (data + own));
}

TEST(MaximumLikelihood, StaysWithinBoundsAndWhereTheModelCanBeEvaluated) {
  const VectorXd series = normal_series();
  const auto densities = [&](const VectorXd& psi) -> std::optional<VectorXd> {
    if (psi[1] < -0.4) return std::nullopt;
    return normal_densities(series)(psi);
  };
  const auto cut = maximise_likelihood(densities, {{.start = 0.0, .upper = 1.5}, {.start = 1.0}});
  ASSERT_TRUE(cut);
  EXPECT_DOUBLE_EQ(cut->estimate[0], 1.5);
  EXPECT_GE(cut->estimate[1], -0.4);
  EXPECT_FALSE(maximise_likelihood(densities, {{.start = 0.0}, {.start = -1.0}}));
}

}  // namespace
}  // namespace kalfem
