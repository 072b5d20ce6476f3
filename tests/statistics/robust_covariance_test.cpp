// SPDX-License-Identifier: Apache-2.0
#include "kalfem/statistics/robust_covariance.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <numbers>

#include "base/absent.hpp"
#include "base/data_folder.hpp"
#include "kalfem/base/random.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

/// First differences of the US wholesale price index, 124 quarters.
VectorXd differences(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string title;
  in >> title;
  std::vector<double> values;
  for (double value = 0.0; in >> value;) values.push_back(value);
  VectorXd found(static_cast<Index>(values.size()) - 1);
  for (Index k = 0; k < found.size(); ++k)
    found[k] = values[static_cast<std::size_t>(k) + 1] - values[static_cast<std::size_t>(k)];
  return found;
}

/// Log-densities of each sample given those before of an ARMA(1,1) process about a mean, parameters (phi, theta, mean,
/// sigma), by a Kalman filter of state [x_k; theta e_k] that starts in the stationary distribution.
VectorXd log_densities(const VectorXd& series, const VectorXd& parameters) {
  const double phi = parameters[0], theta = parameters[1], mean = parameters[2], sigma = parameters[3];
  Eigen::Matrix2d transition;
  transition << phi, 1.0, 0.0, 0.0;
  const Vector2d gain(1.0, theta);
  const double variance = (1.0 + 2.0 * phi * theta + theta * theta) / (1.0 - phi * phi);
  Eigen::Matrix2d covariance;
  covariance << variance, theta, theta, theta * theta;
  covariance *= sigma * sigma;
  Vector2d state = Vector2d::Zero();
  VectorXd densities(series.size());
  for (Index k = 0; k < series.size(); ++k) {
    const double innovation = series[k] - mean - state[0], s = covariance(0, 0);
    densities[k] = -0.5 * (std::log(2.0 * std::numbers::pi * s) + innovation * innovation / s);
    const Vector2d column = covariance.col(0);
    state = transition * (state + column * innovation / s);
    covariance = transition * (covariance - column * column.transpose() / s) * transition.transpose() +
                 sigma * sigma * gain * gain.transpose();
  }
  return densities;
}

/// Derivatives of a vector function by central differences of sixth order, one column a parameter.
MatrixXd jacobian(const std::function<VectorXd(const VectorXd&)>& function, const VectorXd& at) {
  constexpr std::array<double, 3> weights{0.75, -0.15, 1.0 / 60.0};
  constexpr double step = 2e-3;
  MatrixXd columns;
  for (Index i = 0; i < at.size(); ++i) {
    VectorXd column;
    for (int m = 1; m <= 3; ++m) {
      VectorXd above = at, below = at;
      above[i] += m * step;
      below[i] -= m * step;
      const VectorXd part = weights[static_cast<std::size_t>(m) - 1] * (function(above) - function(below)) / step;
      column = m == 1 ? part : VectorXd(column + part);
    }
    if (i == 0) columns.resize(column.size(), at.size());
    columns.col(i) = column;
  }
  return columns;
}

// The standard errors that Stata prints for this model, as statsmodels' tests reproduce them to seven digits.
TEST(RobustCovariance, OfAStateSpaceLikelihoodIsThatOfPublishedPrograms) {
  const auto file = data_folder("wpi1") / "wpi1.csv";
  if (!std::filesystem::exists(file)) KALFEM_ABSENT("the wholesale price index is absent");
  const VectorXd series = differences(file);
  ASSERT_EQ(series.size(), 123);
  const auto densities = [&](const VectorXd& at) { return log_densities(series, at); };
  const auto gradient = [&](const VectorXd& at) -> VectorXd { return jacobian(densities, at).colwise().sum(); };
  // The published estimates, where that program stopped: 2e-5 beside the maximum, which changes the fifth digit of the
  // standard errors but not the likelihood.
  const VectorXd estimate = VectorXd{{0.8742288, -0.4120458, 0.7498197, 0.7250436}};
  EXPECT_NEAR(densities(estimate).sum(), -135.35131, 5e-6);
  const MatrixXd scores = jacobian(densities, estimate).transpose(), information = -jacobian(gradient, estimate);
  const auto deviation = [](const MatrixXd& covariance, Index i) { return std::sqrt(covariance(i, i)); };
  const MatrixXd opg = (scores * scores.transpose()).inverse(), hessian = information.inverse();
  const double n = 123.0;
  const MatrixXd robust = n / (n - 1.0) * white_robust_covariance(information, scores);
  constexpr double published = 1e-6;  // printed to seven digits behind the point; found within 5e-8
  EXPECT_NEAR(deviation(opg, 0), 0.0545435, published);
  EXPECT_NEAR(deviation(opg, 1), 0.1000284, published);
  EXPECT_NEAR(deviation(hessian, 0), 0.0637705, published);
  EXPECT_NEAR(deviation(hessian, 1), 0.1220756, published);
  EXPECT_NEAR(deviation(robust, 0), 0.0811246, published);
  EXPECT_NEAR(deviation(robust, 1), 0.1503862, published);
}

// The mean of a series with first-order autocorrelation that its model takes for white: deviation sqrt(1.9 / 0.1)
// wider.
TEST(RobustCovariance, AllowsForCorrelatedScores) {
  const Index samples = 20000;
  RandomStream random(5, "mean");
  VectorXd series(samples);
  double last = 0.0;
  for (Index k = 0; k < samples; ++k) series[k] = last = 0.9 * last + random.normal();
  const double variance = 1.0 / (1.0 - 0.81);
  const MatrixXd scores = ((series.array() - series.mean()) / variance).matrix().transpose();
  const MatrixXd information = MatrixXd::Constant(1, 1, static_cast<double>(samples) / variance);
  const auto robust = robust_covariance(information, MatrixXd::Zero(1, 1), scores);
  const double naive = std::sqrt(1.0 / information(0, 0));
  EXPECT_NEAR(std::sqrt(robust.covariance(0, 0)) / naive, std::sqrt(19.0), 0.5);  // found 4.1 of 4.36
  EXPECT_EQ(robust.rank, 1);
  EXPECT_GT(robust.bandwidth, 50.0);
}

TEST(RobustCovariance, CountsThePriorAsStatedAndTellsTheRank) {
  const MatrixXd prior = MatrixXd::Identity(2, 2) * 4.0;
  const auto of_prior = robust_covariance(prior, prior, MatrixXd::Zero(2, 10));
  EXPECT_TRUE(of_prior.covariance.isApprox(0.25 * MatrixXd::Identity(2, 2), 1e-14));
  // Two parameters of which only the sum shows, in units a billion apart.
  MatrixXd information(2, 2);
  information << 1.0, 1e9, 1e9, 1e18;
  const auto found = robust_covariance(information, MatrixXd::Zero(2, 2), MatrixXd::Ones(2, 100));
  EXPECT_EQ(found.rank, 1);
  EXPECT_TRUE(found.covariance.allFinite());
}

}  // namespace
}  // namespace kalfem
