// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/noise_level.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "kalfem/base/random.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr Index samples = 20000;

/// A slow motion with white noise, one row a standard deviation; from `change` on it is `ratio` times as large.
MatrixXd noisy(const std::vector<double>& deviations, Index change = samples, double ratio = 1.0) {
  MatrixXd values(static_cast<Index>(deviations.size()), samples);
  for (std::size_t c = 0; c < deviations.size(); ++c) {
    RandomStream random(3 + c, "noise");
    for (Index k = 0; k < samples; ++k)
      values(static_cast<Index>(c), k) =
          std::sin(2e-3 * double(k)) + deviations[c] * (k < change ? 1.0 : ratio) * random.normal();
  }
  return values;
}

// The median of 20,000 squares of third differences, which depend on each other over three samples, tells a standard
// deviation to 1.0 %, the mean of the logarithms of 8,000 to 1.6 %: three times that.
constexpr double scatter = 0.03, scatter_of_parts = 0.045;

TEST(NoiseLevel, IsTheStandardDeviationOfWhiteNoise) {
  const auto level = noise_level(noisy({1e-3, 0.2, 7.0}));
  EXPECT_NEAR(level[0] / 1e-3, 1.0, scatter);
  EXPECT_NEAR(level[1] / 0.2, 1.0, scatter);
  EXPECT_NEAR(level[2] / 7.0, 1.0, scatter);
}

TEST(NoiseLevel, IsNotMovedByJumpsAndMissingSamples) {
  MatrixXd values = noisy({0.2});
  values.rightCols(samples / 2).array() += 100.0;
  values(0, 77) = 1e6;
  values.block(0, 500, 1, 2000).setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_NEAR(noise_level(values)[0] / 0.2, 1.0, scatter);
}

TEST(NoiseLevel, IsZeroWithoutFourSamplesInARow) {
  EXPECT_EQ(noise_level(MatrixXd::Ones(1, 3))[0], 0.0);
  MatrixXd values = noisy({0.2});
  for (Index k = 0; k < samples; k += 3) values(0, k) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(noise_level(values)[0], 0.0);
  EXPECT_EQ(noise_level(MatrixXd::Constant(1, 100, 3.0))[0], 0.0);
}

/// The place to a few samples.
TEST(NoiseChange, HasItsPlaceAndBothLevels) {
  const auto change = strongest_noise_change(noisy({1e-3, 0.2}, 8000, 6.0), 30);
  EXPECT_NEAR(double(change.sample), 8000.0, 5.0);
  EXPECT_NEAR(change.before[0] / 1e-3, 1.0, scatter_of_parts);
  EXPECT_NEAR(change.after[0] / 6e-3, 1.0, scatter_of_parts);
  EXPECT_NEAR(change.before[1] / 0.2, 1.0, scatter_of_parts);
  EXPECT_NEAR(change.after[1] / 1.2, 1.0, scatter_of_parts);
}

}  // namespace
}  // namespace kalfem
