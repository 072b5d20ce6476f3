// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "kalfem/estimation/unknowns_history.hpp"

// Innovations of a filter that knows the constants, from the run that estimates them: exact for a linear measurement.

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double noise = 0.3;

/// h_k of the measurement y_k = h_k^T theta + v_k, theta of two constants.
VectorXd slope_at(Index k) {
  const auto time = 0.1 * static_cast<double>(k);
  return VectorXd{{1.0 + 0.5 * std::sin(time), std::cos(1.7 * time)}};
}

double measured_at(Index k) {
  return slope_at(k).dot(VectorXd{{2.0, -1.0}}) + noise * std::sin(12.9898 * static_cast<double>(k));
}

/// Recursive least squares over the samples, as the filter of joint state and parameters keeps it.
UnknownsHistory history_of(Index samples) {
  UnknownsHistory history{.unknowns = {0, 1}};
  const VectorXd prior{{1.0, 0.5}};
  VectorXd mean = prior;
  MatrixXd covariance = MatrixXd::Identity(2, 2);
  history.mean.resize(2, samples + 1);
  history.covariance.resize(2, 2 * (samples + 1));
  history.mean.col(0) = mean;
  history.covariance_at(0) = covariance;
  history.at_prior.resize(1, samples);
  history.slope.resize(2, samples);
  history.deviation = MatrixXd::Constant(1, samples, noise);
  for (Index k = 0; k < samples; ++k) {
    const VectorXd h = slope_at(k);
    history.slope_at(k) = h;
    history.at_prior(0, k) = measured_at(k) - h.dot(prior);
    const VectorXd gain = covariance * h / (h.dot(covariance * h) + noise * noise);
    mean += gain * (measured_at(k) - h.dot(mean));
    covariance -= gain * (covariance * h).transpose();
    history.mean.col(k + 1) = mean;
    history.covariance_at(k + 1) = covariance;
  }
  return history;
}

TEST(SensitiveInnovations, AreTheResidualsAtTheLastEstimateAndTheirDerivatives) {
  constexpr Index samples = 50, first = 10;
  const auto history = history_of(samples);
  const auto found = sensitive_innovations(history, first);
  ASSERT_EQ(found.value.cols(), samples - first);
  ASSERT_EQ(found.derivative.size(), 2U);
  for (Index k = first; k < samples; ++k) {
    const VectorXd h = slope_at(k);
    EXPECT_NEAR(found.value(0, k - first), (measured_at(k) - h.dot(history.mean.col(history.last()))) / noise, 1e-12)
        << k;
    for (Index i = 0; i < 2; ++i)
      EXPECT_NEAR(found.derivative[static_cast<std::size_t>(i)](0, k - first), -h[i] / noise, 1e-12) << k;
  }
}

TEST(SensitiveInnovations, AreNoneWhereTheHistoryHoldsNone) {
  auto history = history_of(20);
  EXPECT_EQ(sensitive_innovations(history, 20).value.size(), 0);
  history.slope.resize(2, 0);
  EXPECT_EQ(sensitive_innovations(history, 0).value.size(), 0);
}

}  // namespace
}  // namespace kalfem
