// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <random>

#include "kalfem/records/record_splice.hpp"

// A jump counts from six standard deviations of the noise's second difference, sqrt(6) times those of the noise, on.
namespace kalfem {
namespace {

using Eigen::Index;

constexpr double quiet = 2e-7, noisy = 1e-5;
constexpr Index change = 400, missing = 2;

/// Three straight motions that get noisy at a sample and jump there by `jump` standard deviations of that noise.
Record record_with_jump(double jump, unsigned seed) {
  Record record{500.0, 0.0, {{"a", "m"}, {"b", "m"}, {"c", "m"}}, Eigen::MatrixXd(3, 1500)};
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  const double step = jump * noisy / double(missing);
  for (Index k = 0; k < record.samples(); ++k)
    for (Index c = 0; c < 3; ++c)
      record.values(c, k) =
          step * double(k < change ? k : k + missing) + (k < change ? quiet : noisy) * normal(generator);
  return record;
}

TEST(KinkSize, IsMeasuredByTheNoiseOfSecondDifferences) {
  // Six deviations of the second difference are 14.7 of the noise. The noise of one sample moves the jump by 3 at most.
  for (unsigned seed = 1; seed <= 10; ++seed) {
    EXPECT_FALSE(find_splice(record_with_jump(10.0, seed))) << seed;
    EXPECT_TRUE(find_splice(record_with_jump(20.0, seed))) << seed;
  }
}

}  // namespace
}  // namespace kalfem
