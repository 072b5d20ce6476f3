// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/scaling.hpp"

#include <gtest/gtest.h>

#include "base/processor_time.hpp"

namespace kalfem {
namespace {

TEST(UnitColumns, HaveLengthOneOrNone) {
  Eigen::MatrixXd columns(3, 3);
  columns << 3.0, 0.0, 1e-200, 4.0, 0.0, 0.0, 0.0, 0.0, 0.0;
  const Eigen::MatrixXd found = unit_columns(columns);
  EXPECT_DOUBLE_EQ(found(0, 0), 0.6);
  EXPECT_DOUBLE_EQ(found(1, 0), 0.8);
  EXPECT_TRUE(found.col(1).isZero(0.0));
}

/// Rigid-body motions of a large model. Lengths that are summed up for every entry take some 30 s here.
TEST(UnitColumns, TakeTimeInProportionToTheRows) {
  const Eigen::MatrixXd columns = Eigen::MatrixXd::Constant(600'000, 6, 2.0);
  const double begin = processor_seconds();
  const Eigen::MatrixXd found = unit_columns(columns);
  EXPECT_LT(processor_seconds() - begin, 3.0);
  EXPECT_NEAR(found.squaredNorm(), 6.0, 2.5e-10);  // rounding of a sum of 3.6e6 squares
}

}  // namespace
}  // namespace kalfem
