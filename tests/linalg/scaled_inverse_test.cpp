// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/scaled_inverse.hpp"

#include <gtest/gtest.h>

namespace kalfem {
namespace {

using Eigen::MatrixXd;

/// Of a stiffness, a clearance and a friction force: variances fifteen orders apart.
MatrixXd covariance_of(double correlation) {
  const Eigen::Vector3d deviation(1e7, 3e-1, 2.0);
  MatrixXd covariance = MatrixXd::Identity(3, 3);
  covariance(0, 1) = covariance(1, 0) = correlation;
  return deviation.asDiagonal() * covariance * deviation.asDiagonal();
}

TEST(ScaledInverse, IsThatOfEachCovarianceAlone) {
  ScaledInverse inverse;
  for (const double correlation : {0.0, 0.9, -0.3}) {
    const MatrixXd covariance = covariance_of(correlation);
    EXPECT_EQ(inverse(covariance), scaled_inverse(covariance));
    EXPECT_TRUE((covariance * inverse(covariance)).isIdentity(1e-6)) << correlation;
  }
}

TEST(ScaledInverse, TakesAnotherSize) {
  ScaledInverse inverse;
  EXPECT_EQ(inverse(covariance_of(0.5)).rows(), 3);
  EXPECT_EQ(inverse(MatrixXd::Constant(1, 1, 4.0))(0, 0), 0.25);
}

}  // namespace
}  // namespace kalfem
