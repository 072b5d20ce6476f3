// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/estimation/sensor_course.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "kalfem/base/random.hpp"
#include "kalfem/steps/estimation/outcome.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd white(const char* name, Index count) {
  RandomStream stream(3, name);
  VectorXd values(count);
  for (double& value : values) value = stream.normal();
  return values;
}

/// A sensor whose innovations are white of deviation 2, as expected, settled after 100 of 5100 samples at 100 Hz.
EstimationOutcome outcome_of(const VectorXd& standardised) {
  EstimationOutcome outcome;
  outcome.measurements.sample_rate = 100.0;
  outcome.measurements.channels = {{"a", "m/s^2"}};
  outcome.measurements.values = VectorXd::LinSpaced(standardised.size(), 0.0, 1.0).transpose();
  outcome.result.innovation = 2.0 * standardised.transpose();
  outcome.result.innovation_deviation = MatrixXd::Constant(1, standardised.size(), 2.0);
  outcome.settled = 100;
  return outcome;
}

TEST(SensorCourse, AgreesWithWhatIsExpected) {
  const SensorCourse sensor(outcome_of(white("e", 5100)), 0);
  EXPECT_EQ(sensor.known, 5000);
  EXPECT_NEAR(sensor.size(), 1.0, 0.03);
  EXPECT_NEAR(sensor.inside_95(), 0.95, 0.01);
  EXPECT_GT(sensor.share(Agreement::green), 0.88);
  EXPECT_LT(sensor.share(Agreement::red), 0.02);
}

TEST(SensorCourse, FindsTheWorstMoment) {
  VectorXd standardised = white("e", 5100);
  standardised.segment(2100, 50) *= 4.0;  // 21.0 s to 21.5 s
  const SensorCourse sensor(outcome_of(standardised), 0);
  EXPECT_NEAR(sensor.worst_time(), 21.25, 0.26);
  EXPECT_GT(sensor.share(Agreement::red), 0.005);
}

TEST(SensorCourse, InnovationsThatAreTooSmallAreToldFromThoseThatAreTooLarge) {
  const SensorCourse sensor(outcome_of(0.3 * white("e", 5100)), 0);
  EXPECT_EQ(sensor.share(Agreement::small), 1.0);
  EXPECT_EQ(SensorCourse(outcome_of(3.0 * white("e", 5100)), 0).share(Agreement::red), 1.0);
}

TEST(SensorCourse, ARecordShorterThanAWindowIsOne) {
  const SensorCourse sensor(outcome_of(white("e", 107)), 0);
  EXPECT_EQ(sensor.windows.size(), 1U);
  EXPECT_EQ(sensor.share(Agreement::green) + sensor.share(Agreement::amber) + sensor.share(Agreement::red) +
                sensor.share(Agreement::small),
            1.0);
  const SensorCourse empty(outcome_of(VectorXd::Constant(107, std::nan(""))), 0);
  EXPECT_EQ(empty.share(Agreement::green), 0.0);
}

TEST(SensorCourse, MissingSamplesDoNotCount) {
  VectorXd standardised = white("e", 5100);
  standardised.segment(1000, 500).setConstant(std::nan(""));
  const SensorCourse sensor(outcome_of(standardised), 0);
  EXPECT_EQ(sensor.known, 4500);
  EXPECT_EQ(std::ranges::count(sensor.windows, Agreement::missing), 10);
  EXPECT_NEAR(sensor.size(), 1.0, 0.03);
}

TEST(SensorCourse, WithoutAnySampleHasNoInnovations) {
  const SensorCourse sensor(outcome_of(VectorXd::Constant(500, std::nan(""))), 0);
  EXPECT_FALSE(sensor.has_innovations());
}

TEST(Correlogram, IsThatOfAnAutoregression) {
  const VectorXd noise = white("n", 40000);
  VectorXd sequence(noise.size());
  sequence[0] = noise[0];
  for (Index k = 1; k < noise.size(); ++k) sequence[k] = 0.6 * sequence[k - 1] + noise[k];
  const auto values = correlogram(sequence, 3);
  ASSERT_EQ(values.size(), 4u);
  for (int lag = 0; lag <= 3; ++lag) EXPECT_NEAR(values[static_cast<std::size_t>(lag)], std::pow(0.6, lag), 0.02);
  EXPECT_TRUE(correlogram(noise.head(11), 3).empty());
}

TEST(CrossCorrelogram, FindsTheLagByWhichOneFollowsTheOther) {
  const VectorXd cause = white("c", 5000);
  VectorXd effect = white("n", 5000);
  effect.tail(4993) += 2.0 * cause.head(4993);  // seven samples later
  const auto values = cross_correlogram(effect, cause, 20);
  ASSERT_EQ(values.size(), 21u);
  EXPECT_NEAR(values[7], 2.0 / std::sqrt(5.0), 0.03);
  EXPECT_LT(std::abs(values[3]), 0.06);
  EXPECT_TRUE(cross_correlogram(effect, VectorXd::Ones(5000), 20).empty()) << "nothing moves";
}

}  // namespace
}  // namespace kalfem
