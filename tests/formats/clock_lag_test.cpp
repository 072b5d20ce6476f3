// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/clock_lag.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/random.hpp"
#include "kalfem/records/channel_calibration.hpp"

// A channel whose clock is late and runs fast, against its motion in closed form.
namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double rate = 200.0;
constexpr Index samples = 4000;

/// Thirty sines up to 87 % of the Nyquist frequency, which begin and end softly: what is beyond the record is nothing.
double motion(double t) {
  double sum = 0.0;
  for (int i = 1; i <= 30; ++i) sum += std::sin(2.0 * std::numbers::pi * 2.9 * i * t + 0.7 * i * i);
  return sum * std::exp(-std::pow((t - 13.0) / 1.9, 2));
}

Record recorded(const ClockLag& lag, double start) {
  VectorXd values(samples);
  for (Index k = 0; k < samples; ++k) values[k] = motion(lag.time_of(start + static_cast<double>(k) / rate));
  return make_record(rate, {{"a", values}}, start);
}

/// Where samples are there.
double largest(const VectorXd& error) { return error.array().isFinite().select(error.array().abs(), 0.0).maxCoeff(); }

// Tolerance: the polynomial in the fraction of a sample is good to 1e-9 of thirty sines.
TEST(ClockLag, IsTakenOutAtEveryFrequency) {
  for (const double drift : {50e-6, -3e-4, 2e-2}) {
    const ClockLag lag{0.0123, drift, 3.0};
    const Record record = recorded(lag, 3.0);
    const VectorXd found = without_lag(record, 0, lag);
    VectorXd error(samples);
    for (Index k = 0; k < samples; ++k) error[k] = found[k] - motion(record.time(k));
    EXPECT_LT(largest(error), 1e-7) << drift;
    EXPECT_LE(found.array().isNaN().count(), std::llround((0.0123 + 20.0 * std::abs(drift)) * rate) + 1);
  }
}

TEST(ClockLag, IsPutInAsItIsTakenOut) {
  const ClockLag lag{-0.004, 3e-4, 3.0};
  Record record = recorded({}, 3.0);
  const VectorXd given = record.values.row(0).transpose();
  record.values.row(0) = with_lag(record, 0, lag).transpose();
  EXPECT_LT(largest(record.values.row(0).transpose() - recorded(lag, 3.0).values.row(0).transpose()), 1e-7);
  EXPECT_LT(largest(without_lag(record, 0, lag) - given), 1e-7);
}

// Interpolation between neighbours would leave two thirds of the variance of white noise.
TEST(ClockLag, LeavesWhiteNoiseAsLarge) {
  RandomStream random(1, "noise");
  VectorXd values(samples);
  for (double& value : values) value = random.normal();
  constexpr Index ends = 200;
  const Record record = make_record(rate, {{"a", values}});
  const VectorXd moved = without_lag(record, 0, {0.0, 1.5e-4, 0.0});  // 0 to 0.6 samples
  EXPECT_NEAR(
      moved.segment(ends, samples - 2 * ends).squaredNorm() / values.segment(ends, samples - 2 * ends).squaredNorm(),
      1.0, 0.03);
}

TEST(ClockLag, MissingSamplesMoveAlong) {
  Record record = recorded({}, 0.0);
  record.values(0, 2000) = std::numeric_limits<double>::quiet_NaN();
  // 3 samples late at 10 s, 6 at the end
  const VectorXd moved = without_lag(record, 0, {0.0, 1.5e-3, 0.0});
  EXPECT_TRUE(std::isnan(moved[1997]));
  EXPECT_EQ(moved.array().isNaN().count(), 1 + 6);
}

TEST(ClockLag, NumbersThatAreNoClockAreRefused) {
  const Record record = recorded({}, 0.0);
  for (const ClockLag& lag : {ClockLag{0.0, 50.0}, {std::numeric_limits<double>::infinity()}, {0.0, std::nan("")}})
    EXPECT_THROW(without_lag(record, 0, lag), InvalidInput);
}

TEST(ClockLag, IsAPartOfACalibration) {
  const ClockLag lag{0.0, 3e-4, 3.0};
  Record record = recorded(lag, 3.0);
  const VectorXd expected = 0.5 * (without_lag(record, 0, lag).array() - 0.25);
  EXPECT_TRUE(ChannelCalibration{.drift = 3e-4}.changes_anything());
  calibrate(record, 0, {.gain = 2.0, .offset = 0.25, .drift = 3e-4});
  EXPECT_LT(largest(record.values.row(0).transpose() - expected), 1e-12);
}

}  // namespace
}  // namespace kalfem
