#include "kalfem/records/spectrum.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace kalfem {
namespace {

Eigen::VectorXd sine(double amplitude, double frequency) {
  return amplitude * (2.0 * std::numbers::pi * frequency / 1000.0 * Eigen::ArrayXd::LinSpaced(4000, 0.0, 3999.0)).sin();
}

TEST(Spectrum, ErrorOutsideTheBandDoesNotCount) {
  const Eigen::VectorXd reference = sine(2.0, 20.3), estimate = reference + sine(0.1, 30.7) + sine(5.0, 150.0);
  // 0.1 / 2 of the in-band tone; the tone at 150 Hz leaks by the window's side lobes alone.
  EXPECT_NEAR(nrmse_in_band(estimate, reference, 1000.0, {0.5, 40.0}), 0.05, 2e-11);
  EXPECT_GT(nrmse_in_band(estimate, reference, 1000.0, {0.5, 200.0}), 2.0);
}

/// 3,989 is a prime: the transform is taken at 4,000.
TEST(Spectrum, LengthDoesNotMatter) {
  const Eigen::VectorXd reference = sine(2.0, 20.3).head(3989), estimate = reference + sine(0.1, 30.7).head(3989);
  EXPECT_NEAR(nrmse_in_band(estimate, reference, 1000.0, {0.5, 40.0}), 0.05, 2e-11);
}

TEST(Spectrum, NothingInTheBandIsNoNumber) {
  EXPECT_TRUE(std::isnan(nrmse_in_band(sine(1.0, 20.0), Eigen::VectorXd::Zero(4000), 1000.0, {1.0, 40.0})));
}

}  // namespace
}  // namespace kalfem
