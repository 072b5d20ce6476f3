// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/discretisation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

TEST(ProcessNoiseCovariance, DoubleIntegratorHasItsClosedForm) {
  const Eigen::Matrix2d A{{0, 1}, {0, 0}};
  const Eigen::Matrix2d Qc{{0, 0}, {0, 3.0}};
  const double rounding = 5e-15;
  for (const double h : {1e-6, 0.01, 20.0}) {
    const Eigen::MatrixXd Q = process_noise_covariance(A, Qc, h);
    EXPECT_NEAR(Q(0, 0) / (h * h * h), 1.0, rounding);
    EXPECT_NEAR(Q(0, 1) / (h * h), 1.5, rounding);
    EXPECT_NEAR(Q(1, 1) / h, 3.0, rounding);
  }
}

TEST(ProcessNoiseCovariance, DampedOscillatorReachesItsStationaryVariance) {
  const double w = 2 * M_PI * 300.0, zeta = 0.02, q = 5.0;
  const Eigen::Matrix2d A{{0, 1}, {-w * w, -2 * zeta * w}};
  const Eigen::Matrix2d Qc{{0, 0}, {0, q}};
  // |A| h = 7e5 unbalanced and exp(2 zeta w h) = 1e9 in the block exponential over the whole interval
  const Eigen::MatrixXd Q = process_noise_covariance(A, Qc, 0.3);
  const double variance = q / (4 * zeta * w * w * w);  // of the displacement under white noise
  // exp(-2 zeta w h) = 1.5e-10 is not yet there: found is that
  EXPECT_NEAR(Q(0, 0) / variance, 1.0, 3e-10);
  EXPECT_NEAR(Q(1, 1) / (variance * w * w), 1.0, 3e-10);
}

TEST(ProcessNoiseCovariance, StiffAndSlowTogether) {
  const Eigen::Matrix2d A{{-1e7, 0}, {0, -0.5}};
  const Eigen::Matrix2d Qc{{4.0, 1.0}, {1.0, 2.0}};
  const double h = 0.1;
  const Eigen::MatrixXd Q = process_noise_covariance(A, Qc, h);
  // Q_ij = q_ij (1 - exp(-(a_i + a_j) h)) / (a_i + a_j); 22 doublings leave 2e-11 of the slow pole
  EXPECT_NEAR(Q(0, 0) / (4.0 / 2e7), 1.0, 1e-14);
  EXPECT_NEAR(Q(0, 1) / (1.0 / (1e7 + 0.5)), 1.0, 1e-14);
  EXPECT_NEAR(Q(1, 1) / (2.0 * -std::expm1(-h)), 1.0, 2e-10);
  EXPECT_EQ(Q(0, 1), Q(1, 0));
}

TEST(ProcessNoiseCovariance, SolvesItsLyapunovEquation) {
  const Eigen::Matrix3d A{{-1, 20, 0}, {-30, -0.5, 1}, {0.4, -2, -200}};
  const Eigen::Matrix3d Qc = Eigen::Vector3d(1, 0.1, 7).asDiagonal();
  // stable: over a long interval A Q + Q A^T + Qc = 0
  const Eigen::MatrixXd Q = process_noise_covariance(A, Qc, 60.0);
  // found 1.2e-14: rounding of the largest entry of A, 200, and of the doublings
  EXPECT_LT((A * Q + Q * A.transpose() + Qc).norm() / Qc.norm(), 2e-13);
}

TEST(ProcessNoiseCovariance, RefusesWhatIsNotANumber) {
  const Eigen::MatrixXd one = Eigen::MatrixXd::Ones(1, 1);
  EXPECT_THROW(process_noise_covariance(one * std::numeric_limits<double>::infinity(), one, 1.0), InvalidInput);
  EXPECT_THROW(process_noise_covariance(one, one * std::nan(""), 1.0), InvalidInput);
  EXPECT_THROW(process_noise_covariance(one, one, -1.0), InvalidInput);
  EXPECT_THROW(process_noise_covariance(one, Eigen::MatrixXd::Ones(2, 2), 1.0), InvalidInput);
}

}  // namespace
}  // namespace kalfem
