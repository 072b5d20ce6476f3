// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>

#include "kalfem/steps/point_errors.hpp"

namespace kalfem {
namespace {

using Eigen::VectorXd;

PointQuantity moving(const std::string& name, ObservedQuantity quantity, double amplitude) {
  return {name, quantity, {}, {}, VectorXd::LinSpaced(100, -amplitude, amplitude), {}, {}};
}

TEST(RestingPoints, AreThoseBelowAMillionthOfTheirKind) {
  using enum ObservedQuantity;
  const std::vector<PointQuantity> points{moving("a", displacement, 1e-3), moving("b", displacement, 2e-9),
                                          moving("c", displacement, 0.5e-9), moving("d", displacement, 0.0),
                                          moving("e", acceleration, 1e-9)};
  const RestingPoints resting(points, 0);
  EXPECT_FALSE(resting.rests(points[0]));
  EXPECT_FALSE(resting.rests(points[1]));
  EXPECT_TRUE(resting.rests(points[2]));
  EXPECT_TRUE(resting.rests(points[3]));
  EXPECT_FALSE(resting.rests(points[4])) << "the largest of its kind moves, however little";
}

TEST(RestingPoints, OnlySettledSamplesCount) {
  auto points =
      std::vector{moving("a", ObservedQuantity::displacement, 1.0), moving("b", ObservedQuantity::displacement, 1.0)};
  points[1].truth.tail(50).setZero();
  EXPECT_FALSE(RestingPoints(points, 0).rests(points[1]));
  EXPECT_TRUE(RestingPoints(points, 50).rests(points[1]));
}

TEST(RestingPoints, WithoutAReferenceNothingIsKnownToRest) {
  const PointQuantity unknown{"a", ObservedQuantity::displacement, VectorXd::Zero(10), {}, {}, {}, {}};
  EXPECT_FALSE(RestingPoints({unknown}, 0).rests(unknown));
}

}  // namespace
}  // namespace kalfem
