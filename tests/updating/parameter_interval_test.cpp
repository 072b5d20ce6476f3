// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/parameter_interval.hpp"

#include <gtest/gtest.h>
#include <cmath>
#include <limits>

namespace kalfem {
namespace {

using Eigen::VectorXd;

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Of a stiffness of 100, with these deviations, 5 degrees of freedom of the robust one and bounds from 0.
std::optional<ParameterInterval> interval(double stated, double robust, double upper = infinity) {
  UpdatingParameter parameter;
  parameter.lower = 0.0;
  parameter.upper = upper;
  ParameterStatistics statistics;
  statistics.deviations = VectorXd::Constant(1, stated);
  RobustStatistics scatter;
  scatter.deviations = VectorXd::Constant(1, robust);
  scatter.degrees_of_freedom = 5.0;
  return parameter_interval(parameter, 0, 100.0, statistics, scatter);
}

// 1.959964 of the normal distribution and 2.570582 of Student's t with 5 degrees of freedom, from tables.
TEST(ParameterInterval, IsTheWiderOne) {
  const auto stated = interval(3.0, 1.0);
  ASSERT_TRUE(stated);
  EXPECT_FALSE(stated->robust);
  EXPECT_NEAR(stated->lower, 100.0 - 3.0 * 1.959964, 1e-5);
  EXPECT_NEAR(stated->upper, 100.0 + 3.0 * 1.959964, 1e-5);
  const auto robust = interval(3.0, 4.0);
  EXPECT_TRUE(robust->robust);
  EXPECT_NEAR(robust->upper, 100.0 + 4.0 * 2.570582, 1e-5);
  EXPECT_TRUE(interval(3.0, 2.5)->robust) << "a deviation from few pieces has the heavier tails";
}

TEST(ParameterInterval, EndsAtTheBounds) {
  const auto wide = interval(90.0, 1.0, 150.0);
  EXPECT_EQ(wide->lower, 0.0);
  EXPECT_EQ(wide->upper, 150.0);
}

TEST(ParameterInterval, IsNoneWithoutADeviation) {
  EXPECT_FALSE(interval(infinity, 1.0));
  EXPECT_FALSE(interval(std::nan(""), 1.0));
  EXPECT_FALSE(interval(3.0, std::nan(""))->robust);
}

}  // namespace
}  // namespace kalfem
