// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "formats/measured_record.hpp"
#include "kalfem/records/free_response.hpp"

// The first standstill after a release counts, whatever happens behind it; where there is none, the rest is guessed.
namespace kalfem {
namespace {

using Eigen::Index;

constexpr double sampling = 200.0, let_go = 0.5;

/// Held at 40 mm, let go at 0.5 s, oscillating about 5 mm with the given frequency and damping ratio.
Record released(double duration, double frequency, double damping, double noise = 1e-5) {
  Record record{sampling, 0.0, {}, Eigen::MatrixXd(1, Index(duration * sampling))};
  std::mt19937 generator(5);
  std::normal_distribution<double> normal;
  const double omega = 2.0 * std::numbers::pi * frequency;
  for (Index k = 0; k < record.samples(); ++k) {
    const double since = std::max(0.0, record.time(k) - let_go);
    const double damped = omega * std::sqrt(1.0 - damping * damping);
    record.values(0, k) = 0.005 + 0.035 * std::exp(-damping * omega * since) * std::cos(damped * since);
    record.values(0, k) += noise * normal(generator);
  }
  return record;
}

/// The record with a push of `amplitude` behind it and a long rest elsewhere.
Record nudged(const Record& record, double amplitude) {
  Record longer = record;
  const Index n = record.samples(), more = 4 * n;
  longer.values.conservativeResize(Eigen::NoChange, n + more);
  for (Index k = 0; k < more; ++k) {
    const double since = double(k + 1) / record.sample_rate;
    const double push = amplitude * (0.2 + std::exp(-3.0 * since) * std::sin(10.0 * since));
    longer.values.col(n + k) = record.values.col(n - 1).array() + push;
  }
  return longer;
}

TEST(RestPosition, IsThatOfTheFirstStandstillHoweverLongALaterOneIs) {
  const Record record = released(4.0, 1.5, 0.25);
  const auto alone = find_free_response(record);
  ASSERT_TRUE(alone && alone->rest);
  EXPECT_NEAR(alone->rest->position[0], 0.005, 2e-5);  // what is left of the oscillation
  EXPECT_EQ(alone->rest->last, record.samples() - 1);
  for (const double amplitude : {0.003, -0.02, 0.2}) {  // the last is five times the release
    const auto disturbed = find_free_response(nudged(record, amplitude));
    ASSERT_TRUE(disturbed && disturbed->rest) << amplitude;
    // the same samples decide, so nothing moves
    EXPECT_NEAR(disturbed->release.time, alone->release.time, 1e-9) << amplitude;
    EXPECT_NEAR(disturbed->rest->motion_end_time, alone->rest->motion_end_time, 1e-9) << amplitude;
    EXPECT_NEAR(disturbed->rest->position[0], alone->rest->position[0], 1e-9) << amplitude;
    EXPECT_NEAR(double(disturbed->rest->last), double(record.samples()), 3.0) << amplitude;
  }
}

/// A pause of 0.2 s and more within +-1 % of the excursion is not long for a slow structure.
TEST(RestPosition, IsNotATurningPointOfASlowOscillation) {
  EXPECT_FALSE(find_free_response(released(20.0, 0.2, 0.01))->rest);
  EXPECT_FALSE(find_free_response(released(12.0, 0.1, 0.02))->rest);
  const auto slow = find_free_response(released(60.0, 0.2, 0.15));
  ASSERT_TRUE(slow->rest);
  EXPECT_NEAR(slow->rest->position[0], 0.005, 1e-6);  // noise of 1e-5 over thousands of samples
}

TEST(RestPosition, IsFoundWhereTheMotionCreepsBackWithoutSwinging) {
  const Record record = released(4.0, 1.0, 0.9);
  const auto creeping = find_free_response(record);
  ASSERT_TRUE(creeping && creeping->rest);
  EXPECT_NEAR(creeping->rest->position[0], 0.005, 1.5e-6);  // noise of 1e-5 over some hundred samples
  const auto disturbed = find_free_response(nudged(record, 0.01));
  ASSERT_TRUE(disturbed && disturbed->rest);
  EXPECT_NEAR(disturbed->rest->position[0], 0.005, 1.5e-6);
}

TEST(RestPosition, IsGuessedFromTheLastSwing) {
  for (const double damping : {0.01, 0.05, 0.1}) {
    const Record record = released(3.0, 1.5, damping);
    const auto times = find_free_response(record);
    ASSERT_TRUE(times);
    EXPECT_FALSE(times->rest) << damping;
    const auto guess = guess_rest(record, times->release.sample);
    EXPECT_LT(std::abs(guess.position[0] - 0.005), guess.deviation[0]) << damping;
    // No more than the swing of the last period and a half.
    const double swing = 0.035 * std::exp(-damping * 2.0 * std::numbers::pi * 1.5 * (2.5 - 1.5 / 1.5));
    EXPECT_LT(guess.deviation[0], std::max(swing, 1e-3)) << damping;
  }
}

TEST(RestPosition, OfMeasuredRunsDoesNotMoveWithALaterNudge) {
  const auto runs = measured_runs();
  if (runs.empty()) GTEST_SKIP() << "no measured records at " << measured_runs_folder();
  for (const auto& run : runs) {
    const auto alone = find_free_response(run.record), disturbed = find_free_response(nudged(run.record, 0.01));
    ASSERT_TRUE(alone && alone->rest) << run.key;
    ASSERT_TRUE(disturbed && disturbed->rest) << run.key;
    // the same samples decide, so nothing moves
    EXPECT_NEAR(disturbed->release.time, alone->release.time, 1e-9) << run.key;
    EXPECT_NEAR(disturbed->rest->motion_end_time, alone->rest->motion_end_time, 1e-9) << run.key;
    EXPECT_LT((disturbed->rest->position - alone->rest->position).cwiseAbs().maxCoeff(), 1e-9) << run.key;
  }
}

TEST(RestPosition, OfRunsThatEndTooEarlyIsGuessed) {
  const auto path = measured_runs_folder() / "halfcar_500Hz.h5";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no measured records at " << measured_runs_folder();
  const auto file = Hdf5File::open(path.string());
  for (const char* key : {"/Centre_p0500_m000_t2_r2", "/Centre_p1500_m200_t9_r2"}) {
    const Record record{500.0, 0.0, {}, file.read_columns_as_rows(key)};
    const auto times = find_free_response(record);
    ASSERT_TRUE(times) << key;
    EXPECT_FALSE(times->rest) << key;
    const auto guess = guess_rest(record, times->release.sample);
    EXPECT_LT(guess.position.cwiseAbs().maxCoeff(), 0.016) << key;  // as in the runs that come to rest
    // the last swings are 6 mm
    EXPECT_LT(guess.deviation.maxCoeff(), 0.01) << key;
  }
}

}  // namespace
}  // namespace kalfem
