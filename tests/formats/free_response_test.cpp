// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/free_response.hpp"
#include "base/absent.hpp"

#include <gtest/gtest.h>
#include <cmath>
#include <limits>
#include <random>

#include "formats/measured_record.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/records/isolated_values.hpp"
#include "kalfem/records/local_polynomial.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double rate = 500.0, release_time = 0.5, stop = 2.5;

/// Held at 40 mm, let go at 0.5 s, oscillating about 5 mm with an amplitude that falls linearly to zero at 2.5 s: the
/// decay that dry friction gives.
double position(double time) {
  const double since = time - release_time;
  if (since <= 0.0) return 0.040;
  return 0.005 + 0.035 * std::max(0.0, 1.0 - since / (stop - release_time)) * std::cos(9.42 * since);
}

Record free_response(double noise = 1e-5) {
  Record record;
  record.sample_rate = rate;
  record.values.resize(2, 2000);
  std::mt19937 generator(5);
  std::normal_distribution<double> normal;
  for (Index k = 0; k < 2000; ++k) {
    record.values(0, k) = position(static_cast<double>(k) / rate) + noise * normal(generator);
    record.values(1, k) = noise * normal(generator);  // a dead channel
  }
  return record;
}

TEST(FindRelease, FindsTheFirstDeparture) {
  const auto release = find_release(free_response());
  ASSERT_TRUE(release);
  // By 1 % of the excursion of about 62 mm: 0.62 mm = 17.5 mm/s t + 1550 mm/s^2 t^2 is passed after 15.1 ms.
  EXPECT_NEAR(release->time, release_time + 0.0151, 1.0 / rate);
  // noise of 1e-5 over some hundred samples
  EXPECT_NEAR(release->position[0], 0.040, 3e-6);
}

TEST(FindRelease, SaysNothingWithoutAHoldOrWithoutMotion) {
  auto record = free_response();
  record.values = record.values.rightCols(1700).eval();  // begins in motion
  EXPECT_FALSE(find_release(record));
  record.values = free_response().values.leftCols(200).eval();  // still held
  EXPECT_FALSE(find_release(record));
  record.values.resize(2, 3);
  record.values.setZero();
  EXPECT_FALSE(find_release(record));
}

TEST(FindRelease, IsNotMisledBySpikesAndMissingSamples) {
  auto record = free_response();
  record.values(0, 100) += 0.01;
  record.values.middleCols(180, 20).setConstant(nan);
  const auto release = find_release(record);
  ASSERT_TRUE(release);
  EXPECT_NEAR(release->time, release_time + 0.0151, 2.0 / rate);
}

TEST(FindRest, FindsWhereAndWhenTheMotionEnds) {
  const auto rest = find_rest(free_response(), 260);
  ASSERT_TRUE(rest);
  EXPECT_NEAR(rest->position[0], 0.005, 1.5e-6);  // noise of 1e-5 over some hundred samples
  // The amplitude falls below 1 % of the excursion 35 ms before the stop, and a half period of 0.33 s may pass until
  // then.
  EXPECT_LT(rest->motion_end_time, stop);
  EXPECT_GT(rest->motion_end_time, stop - 0.4);
  EXPECT_EQ(rest->last, 1999);
}

TEST(FindRest, KeepsADisturbanceAtTheEndOut) {
  auto record = free_response();
  record.values.row(0).tail(60).array() -= 0.003;
  const auto rest = find_rest(record, 260);
  ASSERT_TRUE(rest);
  EXPECT_NEAR(rest->position[0], 0.005, 1.5e-6);  // as above
  EXPECT_NEAR(static_cast<double>(rest->last), 1939.0, 1.0);
}

TEST(FindRest, SaysNothingWhileTheMotionGoesOn) {
  auto record = free_response();
  record.values = record.values.leftCols(900).eval();
  EXPECT_FALSE(find_rest(record, 260));
}

/// Wherever one sample is wrong, and by however much, release and rest are those of the record without it.
TEST(FreeResponse, OneSpikeAnywhereDecidesNothing) {
  const auto clean = find_free_response(free_response());
  ASSERT_TRUE(clean && clean->rest);
  for (const Index sample : {0, 1, 3, 20, 49, 120, 248, 260, 700, 1200, 1300, 1500, 1800, 1998, 1999})
    for (const double size : {1e-3, -0.01, 0.2, 1e6}) {
      auto record = free_response();
      record.values(0, sample) += size;
      const auto times = find_free_response(record);
      ASSERT_TRUE(times && times->rest) << sample << ", " << size;
      // As many samples in a row as the rule asks for: a spike among them may put the release behind itself.
      EXPECT_NEAR(times->release.time, clean->release.time, 5.0 / rate) << sample << ", " << size;
      EXPECT_NEAR(times->release.position[0], 0.040, 3e-6) << sample << ", " << size;
      EXPECT_NEAR(times->rest->motion_end_time, clean->rest->motion_end_time, 0.02) << sample << ", " << size;
      EXPECT_NEAR(times->rest->position[0], 0.005, 3e-6) << sample << ", " << size;
    }
}

TEST(IsolatedValues, AreSpikesAlone) {
  Record record = free_response();
  EXPECT_EQ(without_isolated_values(record.values), record.values);
  record.values(0, 700) += 0.01;
  record.values.row(0).segment(1900, 2).array() -= 0.01;
  const Eigen::MatrixXd kept = without_isolated_values(record.values);
  for (const Index sample : {700, 1900, 1901}) EXPECT_TRUE(std::isnan(kept(0, sample))) << sample;
  EXPECT_EQ(kept.array().isNaN().count(), 3);
}

/// A step, a coarsely digitised channel and a sine of six samples a period are no spikes.
TEST(IsolatedValues, AreNotWhatTheNeighboursDo) {
  Eigen::MatrixXd values(3, 300);
  for (Index k = 0; k < 300; ++k) {
    values(0, k) = k < 100 ? 0.0 : 1.0;
    values(1, k) = std::round(3.0 * std::sin(0.02 * static_cast<double>(k)));
    values(2, k) = std::sin(2.0 * M_PI * static_cast<double>(k) / 6.0);
  }
  EXPECT_EQ(without_isolated_values(values), values);
}

TEST(FreeResponse, RefusesOptionsOutOfRange) {
  const auto record = free_response();
  EXPECT_THROW((void)find_release(record, {.hold = nan}), InvalidInput);
  EXPECT_THROW((void)find_release(record, {.departure = 0.0}), InvalidInput);
  EXPECT_THROW((void)find_release(record, {.samples = 0}), InvalidInput);
  EXPECT_THROW((void)find_rest(record, 0, {.still = -1.0}), InvalidInput);
  EXPECT_THROW((void)find_rest(record, 2000), InvalidInput);
  EXPECT_FALSE(find_rest(record, 0, {.still = 1e300}));
}

TEST(LocalMotion, ReadsOffAPolynomialExactly) {
  Record record;
  record.sample_rate = 200.0;
  record.start = -1.0;
  record.values.resize(1, 100);
  for (Index k = 0; k < 100; ++k) {
    const double t = record.time(k);
    record.values(0, k) = 3.0 - 2.0 * t + 5.0 * t * t;
  }
  record.values(0, 52) = nan;
  for (const Index sample : {0, 50, 52, 99}) {
    const double t = record.time(sample);
    const auto motion = local_motion(record, sample, {.half_window = 0.05});
    // rounding, over the half window for the velocity
    EXPECT_NEAR(motion.position[0], 3.0 - 2.0 * t + 5.0 * t * t, 2e-14);
    EXPECT_NEAR(motion.velocity[0], -2.0 + 10.0 * t, 2e-13);
    EXPECT_LT(motion.velocity_deviation[0], 2e-12);
  }
}

TEST(LocalMotion, DeviationsAreThoseOfTheErrors) {
  Record record;
  record.sample_rate = 1000.0;
  std::mt19937 generator(1);
  std::normal_distribution<double> normal;
  record.values.resize(1, 41);
  double position = 0.0, velocity = 0.0;  // sums of (error / stated deviation)^2
  for (int trial = 0; trial < 2000; ++trial) {
    for (Index k = 0; k < 41; ++k) record.values(0, k) = 1e-3 * normal(generator);
    const auto motion = local_motion(record, 20, {.half_window = 0.02});
    position += std::pow(motion.position[0] / motion.position_deviation[0], 2);
    velocity += std::pow(motion.velocity[0] / motion.velocity_deviation[0], 2);
  }
  // Student's t with 38 degrees of freedom: mean square 38/36 = 1.056; four standard errors of 2000 trials are 0.15.
  EXPECT_NEAR(position / 2000.0, 1.056, 0.15);
  EXPECT_NEAR(velocity / 2000.0, 1.056, 0.15);
}

TEST(LocalMotion, RefusesWhatCannotBeFitted) {
  auto record = free_response();
  EXPECT_THROW((void)local_motion(record, -1), InvalidInput);
  EXPECT_THROW((void)local_motion(record, 100, {.half_window = nan}), InvalidInput);
  EXPECT_THROW((void)local_motion(record, 100, {.half_window = 0.002}), InvalidInput);
  EXPECT_THROW((void)local_motion(record, 100, {.degree = 0}), InvalidInput);
  record.values.setConstant(nan);
  EXPECT_THROW((void)local_motion(record, 100), InvalidInput);
  EXPECT_NO_THROW((void)local_motion(free_response(), 100, {.half_window = 1e300}));
}

TEST(FreeResponse, AgreesWithTheOwnersOnEveryMeasuredRun) {
  const auto runs = measured_runs();
  if (runs.empty()) KALFEM_ABSENT("no measured records at " + measured_runs_folder().string());
  for (const auto& run : runs) {
    const auto release = find_release(run.record);
    ASSERT_TRUE(release) << run.key;
    // The owners' rule is another one (about 0.5 mm on both sides); the hand lets go over some 30 ms.
    EXPECT_NEAR(release->time, run.release_time, 0.02) << run.key;
    const auto rest = find_rest(run.record, release->sample);
    ASSERT_TRUE(rest) << run.key;
    EXPECT_GT(rest->motion_end_time, run.release_time + 1.0) << run.key;
    // found up to 15.0 mm, by loads and pressures: the mean of many samples
    EXPECT_LT(rest->position.cwiseAbs().maxCoeff(), 0.016) << run.key;
    // One run is disturbed 0.15 s before its end: its rest ends before that.
    const double length = run.record.time(run.record.samples() - 1);
    const double expected_last = run.key == "Centre_p0000_m000_t1.1_r2" ? 7.9 : length;
    EXPECT_NEAR(run.record.time(rest->last), expected_last, 0.02) << run.key;
  }
}

}  // namespace
}  // namespace kalfem
