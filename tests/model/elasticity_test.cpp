// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "kalfem/model/mesh/properties.hpp"

namespace kalfem {
namespace {

using Eigen::Matrix3d;
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// A strain tensor as [xx yy zz xy yz xz] with engineering shear strains.
Vector6 voigt(const Matrix3d& strain) {
  return (Vector6() << strain(0, 0), strain(1, 1), strain(2, 2), 2 * strain(0, 1), 2 * strain(1, 2), 2 * strain(0, 2))
      .finished();
}

/// The strain energy of a tensor does not depend on the axes in which it is written.
TEST(Elasticity, InGlobalAxesHoldsTheSameEnergy) {
  const Matrix6 half = Matrix6::Random(), local = half * half.transpose();
  const Matrix3d axes = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  const Matrix6 global = in_global_axes(local, axes);
  for (int sample = 0; sample < 5; ++sample) {
    const Matrix3d any = Matrix3d::Random(), strain = any + any.transpose();
    const Vector6 seen = voigt(axes.transpose() * strain * axes), written = voigt(strain);
    EXPECT_NEAR(written.dot(global * written), seen.dot(local * seen), 1e-14 * seen.dot(local * seen));  // rounding
  }
  EXPECT_EQ(global, global.transpose());
}

TEST(Elasticity, OfAnIsotropicMaterialStaysInAnyAxes) {
  const double lambda = 1.2, shear = 0.8;
  Matrix6 isotropic = Matrix6::Zero();
  isotropic.topLeftCorner<3, 3>().setConstant(lambda);
  isotropic.diagonal() << lambda + 2 * shear, lambda + 2 * shear, lambda + 2 * shear, shear, shear, shear;
  const Matrix3d axes = Eigen::AngleAxisd(1.1, Eigen::Vector3d(-1, 0.3, 2).normalized()).toRotationMatrix();
  EXPECT_LT((in_global_axes(isotropic, axes) - isotropic).norm(), 5e-15 * isotropic.norm());  // rounding
}

}  // namespace
}  // namespace kalfem
