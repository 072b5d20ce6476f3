// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/common_delay.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/random.hpp"
#include "kalfem/records/channel_calibration.hpp"

// Two acquisition systems that measured the same.
namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// A sum of forty sines up to 30 Hz that begins and ends softly.
double motion(double time) {
  double sum = 0.0;
  for (int i = 1; i <= 40; ++i) sum += std::sin(2.0 * std::numbers::pi * 0.75 * i * time + 1.7 * i * i);
  return sum * std::exp(-std::pow((time - 6.0) / 3.0, 2));
}

Record recorded(double rate, double start, double duration, double delay, double gain, double noise, int seed) {
  RandomStream random(static_cast<std::uint64_t>(seed), "delay");
  VectorXd values(static_cast<Index>(duration * rate));
  for (Index k = 0; k < values.size(); ++k)
    values[k] = gain * motion(start + double(k) / rate - delay) + noise * random.normal();
  return make_record(rate, {{"a", values}}, start);
}

// 1/50 of the sample interval is 3 deviations at this noise, by the Cramer-Rao bound for white noise.
TEST(CommonDelay, IsFoundToAFractionOfASample) {
  for (const double delay : {0.0, 0.0123, -0.75, 1.5}) {
    const auto found =
        common_delay(recorded(200.0, 1.0, 10.0, 0.0, 1.0, 0.1, 1), recorded(200.0, 0.5, 11.0, delay, 1.0, 0.1, 2));
    EXPECT_NEAR(found.delay, delay, 1e-4) << delay;
    EXPECT_GT(found.correlation, 0.95);
  }
}

TEST(CommonDelay, IsFoundBetweenOtherRatesAndDirections) {
  auto late = recorded(1024.0, 100.0, 12.0, 100.02, -9.81, 0.0, 3);
  late.values(0, 5000) = std::numeric_limits<double>::quiet_NaN();
  const auto found = common_delay(recorded(200.0, 0.0, 12.0, 0.0, 1.0, 0.0, 1), late);
  EXPECT_NEAR(found.delay, 100.02, 1e-4);
  EXPECT_LT(found.correlation, -0.99);
}

TEST(CommonDelay, OfUnrelatedChannelsHasALowCorrelation) {
  RandomStream random(5, "unrelated");
  VectorXd a(2000), b(2000);
  for (Index k = 0; k < 2000; ++k) a[k] = random.normal(), b[k] = random.normal();
  EXPECT_LT(std::abs(common_delay(make_record(100.0, {{"a", a}}), make_record(100.0, {{"b", b}})).correlation), 0.3);
  EXPECT_THROW(common_delay(make_record(100.0, {{"a", a.head(5)}}), make_record(100.0, {{"b", b}})), InvalidInput);
}

TEST(ChannelCalibration, GivesTheSignalBack) {
  Record record = recorded(200.0, 0.0, 12.0, 0.0073, -1.3, 0.0, 1);
  record.values.array() += 0.5;
  calibrate(record, 0, {.gain = -1.3, .offset = 0.5, .delay = 0.0073});
  double error = 0.0;
  for (Index k = 100; k < 2300; ++k) error = std::max(error, std::abs(record.values(0, k) - motion(record.time(k))));
  EXPECT_LT(error, 5e-5);  // found 1.3e-5: the small jump of the continuation beyond the ends; the motion is up to 10
}

}  // namespace
}  // namespace kalfem
