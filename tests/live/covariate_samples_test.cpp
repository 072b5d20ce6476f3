// SPDX-License-Identifier: Apache-2.0
#include "kalfem/live/covariate_samples.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace kalfem {
namespace {

TEST(CovariateSamples, AveragesAWindowAndHoldsTheLastValueForAWhile) {
  CovariateSamples samples;
  samples.add(2.0, 30.0);
  samples.add(1.0, 10.0);  // late
  samples.add(1.5, std::numeric_limits<double>::quiet_NaN());
  samples.add(12.0, 99.0);  // ahead
  EXPECT_DOUBLE_EQ(samples.mean(0.0, 10.0, 30.0), 20.0);
  EXPECT_DOUBLE_EQ(samples.mean(10.0, 20.0, 30.0), 99.0);
  EXPECT_DOUBLE_EQ(samples.mean(20.0, 30.0, 30.0), 99.0);
  EXPECT_TRUE(std::isnan(samples.mean(50.0, 60.0, 30.0)));
}

TEST(CovariateSamples, HasNoValueBeforeTheFirst) {
  CovariateSamples samples;
  samples.add(15.0, 1.0);
  EXPECT_TRUE(std::isnan(samples.mean(0.0, 10.0, 100.0)));
  EXPECT_DOUBLE_EQ(samples.mean(10.0, 20.0, 100.0), 1.0);
}

}  // namespace
}  // namespace kalfem
