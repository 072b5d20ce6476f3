// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/parameter_transform.hpp"

#include <gtest/gtest.h>

#include "kalfem/estimation/consistency.hpp"
#include "kalfem/estimation/estimate.hpp"
#include "kalfem/statistics/quantiles.hpp"

namespace kalfem {
namespace {

const ParameterTransform transforms[] = {
    {TransformKind::none}, {TransformKind::log}, {TransformKind::logit, -2.0, 5.0}};

TEST(ParameterTransform, RoundTrip) {
  for (const auto& transform : transforms)
    // rounding
    for (const double p : {1e-6, 0.3, 1.0, 4.9}) EXPECT_NEAR(transform.to_parameter(transform.to_state(p)), p, 1e-14);
}

TEST(ParameterTransform, SlopeIsTheDerivative) {
  const double h = 1e-5;
  for (const auto& transform : transforms)
    for (const double x : {-3.0, 0.0, 0.7, 4.0}) {
      const double difference = (transform.to_parameter(x + h) - transform.to_parameter(x - h)) / (2 * h);
      EXPECT_NEAR(transform.slope(x), difference, 2e-9 * std::abs(difference));  // central difference: h^2 and eps / h
    }
}

TEST(ParameterTransform, NoStateLeavesTheRange) {
  for (const double x : {-800.0, -40.0, 0.0, 40.0, 800.0}) {
    EXPECT_GE(transforms[1].to_parameter(x), 0.0);
    const double p = transforms[2].to_parameter(x);
    EXPECT_TRUE(p >= -2.0 && p <= 5.0) << x;
  }
}

TEST(ParameterTransform, ArraysFollowTheScalars) {
  const Eigen::ArrayXd states = Eigen::ArrayXd::LinSpaced(9, -4.0, 4.0);
  for (const auto& transform : transforms) {
    Eigen::ArrayXd parameters(9);
    transform.to_parameter(states, parameters);
    // rounding of values of up to 5
    for (Eigen::Index i = 0; i < 9; ++i) EXPECT_NEAR(parameters[i], transform.to_parameter(states[i]), 1e-14);
  }
}

TEST(ConfidenceInterval, HasTheNormalWidthInTheFiltersState) {
  const auto plain = confidence_interval(transforms[0], 2.0, 0.1);
  EXPECT_NEAR(plain.lower, 2.0 - 0.1959963984540054, 1e-15);  // the 97.5 % quantile is 1.959963984540054
  EXPECT_NEAR(plain.upper, 2.0 + 0.1959963984540054, 4e-15);
  const auto logarithmic = confidence_interval(transforms[1], std::log(10.0), 0.5);
  EXPECT_NEAR(logarithmic.lower * logarithmic.upper, 100.0, 5e-13);  // rounding of exp and log of 100
  EXPECT_GT(logarithmic.lower, 0.0);
}

TEST(Quantiles, AreThoseOfTheTables) {
  // published values with sixteen digits
  EXPECT_NEAR(normal_quantile(0.975), 1.959963984540054, 4e-15);
  EXPECT_NEAR(chi_squared_quantile(0.95, 4), 9.487729036781154, 2e-14);
  EXPECT_NEAR(chi_squared_quantile(0.025, 1), 0.0009820691171752583, 1e-16);
}

TEST(Consistency, SummaryCountsWhatWasMeasured) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Eigen::VectorXd nis = (Eigen::VectorXd(5) << 100.0, 2.0, nan, 30.0, 0.5).finished();
  const Eigen::VectorXi measured = (Eigen::VectorXi(5) << 2, 2, 0, 2, 1).finished();
  Eigen::MatrixXd innovation(2, 5);
  innovation << 9, 3, nan, -4, nan, 9, 1, nan, 2, 0.5;
  const auto summary = summarise_consistency(nis, measured, innovation, Eigen::Vector2d(2.0, 0.5), 1);
  // sums of three terms
  EXPECT_NEAR(summary.mean_nis, 32.5 / 3, 1e-14);
  EXPECT_NEAR(summary.expected_nis, 5.0 / 3, 1e-14);
  EXPECT_NEAR(summary.fraction_in_95, 2.0 / 3, 1e-14);  // 30 lies above the 7.38 of two channels
  EXPECT_NEAR(summary.innovation_to_noise[0], std::sqrt(25.0 / 2) / 2.0, 1e-14);
  EXPECT_NEAR(summary.innovation_to_noise[1], std::sqrt(5.25 / 3) / 0.5, 1e-14);
}

}  // namespace
}  // namespace kalfem
