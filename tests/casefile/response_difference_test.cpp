// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "kalfem/vibration/frequency_responses.hpp"

namespace kalfem {
namespace {

using Eigen::VectorXcd;
using Eigen::VectorXd;

const VectorXd lines = VectorXd::LinSpaced(7, 1.0, 7.0);
const VectorXcd full = (VectorXcd(7) << 1.0, 8.0, 10.0, 7.5, 2.0, 0.1, 1.0).finished();

VectorXcd changed(Eigen::Index line, std::complex<double> by) {
  VectorXcd reduced = full;
  reduced[line] += by;
  return reduced;
}

// The lines 2 to 4 Hz have at least 7.07, the peak over the root of 2.
TEST(ResponseDifference, AtAResonanceIsRelativeToItsPeak) {
  const auto difference = difference_of(lines, full, changed(3, {0.0, 0.2}), {2});
  EXPECT_DOUBLE_EQ(difference.at_resonances.value(), 0.02);
  EXPECT_EQ(difference.between.value(), 0.0);
}

TEST(ResponseDifference, BetweenResonancesIsRelativeToTheResponse) {
  const auto difference = difference_of(lines, full, changed(5, 0.001), {2});
  EXPECT_EQ(difference.at_resonances.value(), 0.0);
  EXPECT_NEAR(difference.between.value(), 0.01, 1e-12);  // rounding
  EXPECT_EQ(difference.between_at, 6.0);
}

TEST(ResponseDifference, WithoutPeaksIsBetweenResonancesEverywhere) {
  const auto difference = difference_of(lines, full, changed(2, 1.0), {});
  EXPECT_FALSE(difference.at_resonances);
  EXPECT_DOUBLE_EQ(difference.between.value(), 0.1);
}

TEST(ResponseDifference, LeavesOutLinesWithoutResponse) {
  const VectorXcd none = VectorXcd::Zero(7);
  EXPECT_FALSE(difference_of(lines, none, full, {}).between);
}

}  // namespace
}  // namespace kalfem
