// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/spectrum.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "kalfem/records/error_in_band.hpp"

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

/// What was transformed before leaves nothing behind, not even a signal without power in the band.
TEST(Spectrum, ErrorsOfManyPairsAreThoseOfEachAlone) {
  const FrequencyBand band{0.5, 40.0};
  ErrorInBand error(4000, 1000.0, band);
  const Eigen::VectorXd reference = sine(2.0, 20.3), none = Eigen::VectorXd::Zero(4000);
  EXPECT_TRUE(std::isnan(error(reference, none)));
  for (const double amplitude : {0.1, 0.7, 0.2}) {
    const Eigen::VectorXd estimate = reference + sine(amplitude, 30.7);
    EXPECT_EQ(error(estimate, reference), nrmse_in_band(estimate, reference, 1000.0, band));
  }
}

}  // namespace
}  // namespace kalfem
