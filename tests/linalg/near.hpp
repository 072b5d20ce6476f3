// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Dense>

namespace kalfem::test {

/// Equal but for the rounding of sums of some hundred numbers.
inline void expect_near(const Eigen::MatrixXd& found, const Eigen::MatrixXd& expected) {
  ASSERT_EQ(found.rows(), expected.rows());
  ASSERT_EQ(found.cols(), expected.cols());
  EXPECT_LE((found - expected).norm(), 1e-14 * expected.norm());
}

}  // namespace kalfem::test
