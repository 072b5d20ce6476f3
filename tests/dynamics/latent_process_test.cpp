// SPDX-License-Identifier: Apache-2.0
#include "kalfem/dynamics/latent_process.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// F P + P F^T + q e e^T = 0 holds the covariance that the white noise keeps up.
TEST(LatentProcess, StationaryCovarianceBalancesItsNoise) {
  for (const int order : {1, 2, 3}) {
    const LatentProcess process{order, 0.07};
    const double deviation = 5.0, scale = std::pow(process.rate(), 2 * order - 1) * deviation * deviation;
    MatrixXd dynamics = MatrixXd::Zero(order, order);
    for (Index i = 0; i + 1 < order; ++i) dynamics(i, i + 1) = 1.0;
    dynamics.bottomRows(1) = process.feedback();
    const MatrixXd covariance = process.covariance(deviation);
    MatrixXd balance = dynamics * covariance + covariance * dynamics.transpose();
    balance(order - 1, order - 1) += std::pow(process.density(deviation), 2);
    EXPECT_LT(balance.cwiseAbs().maxCoeff(), 1e-14 * scale) << order;
    EXPECT_EQ(covariance(0, 0), 25.0);
  }
}

/// (s + lambda)^p with lambda = sqrt(2 nu) / l.
TEST(LatentProcess, ForgetsItsValueAsTheMaternCovarianceSays) {
  EXPECT_NEAR((LatentProcess{1, 0.2}.rate()), 5.0, 1e-14);
  EXPECT_NEAR((LatentProcess{3, 0.2}.rate()), std::sqrt(5.0) / 0.2, 1e-13);
  const Eigen::RowVector3d expected(-8.0, -12.0, -6.0);  // (s + 2)^3
  EXPECT_LT((LatentProcess{3, std::sqrt(5.0) / 2.0}.feedback() - expected).norm(), 1e-13);
}

TEST(LatentProcess, RandomWalkForgetsNothing) {
  const LatentProcess walk{1, std::numeric_limits<double>::infinity()};
  EXPECT_EQ(walk.rate(), 0.0);
  EXPECT_EQ(walk.feedback()[0], 0.0);
  EXPECT_EQ(walk.covariance(3.0)(0, 0), 9.0);
}

}  // namespace
}  // namespace kalfem
