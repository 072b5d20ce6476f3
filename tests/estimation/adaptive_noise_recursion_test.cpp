// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "kalfem/base/random.hpp"
#include "kalfem/estimation/adaptive_noise.hpp"

// The recursions alone, on innovations that are drawn from a covariance S = B + R with known parts.

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double memory = 2.0, log_ratio = 0.05;

/// Two sensors of a filter that expects noise R and the share `factor` of a process noise B.
struct TwoSensors {
  RandomStream random;
  MatrixXd B{{3.0, 1.0}, {1.0, 2.0}}, R = Eigen::Vector2d(0.5, 4.0).asDiagonal();

  explicit TwoSensors(std::uint64_t seed) : random(seed, "two sensors") {}

  [[nodiscard]] VectorXd draw() {
    const Eigen::LLT<MatrixXd> root(MatrixXd(B + R));
    return root.matrixL() * VectorXd(Eigen::Vector2d(random.normal(), random.normal()));
  }
  [[nodiscard]] Innovation expected(const VectorXd& value, const MatrixXd& noise, double factor) const {
    return {.channels = {0, 1}, .value = value, .covariance = factor * B + noise};
  }
};

/// R after `duration` seconds from `factor` times the truth, everything else right.
MatrixXd learned_noise(double factor, double rate, double duration, std::uint64_t seed) {
  TwoSensors sensors(seed);
  NoiseRecursion recursion({.sensors = true, .memory = memory}, factor * sensors.R, 1.0 / rate, 1e-6);
  for (int k = 0; k < int(duration * rate); ++k)
    recursion.learn(sensors.expected(sensors.draw(), recursion.measurement_noise(), 1.0), nullptr, log_ratio);
  return recursion.measurement_noise();
}

double learned_factor(double stated, double rate, double duration, std::uint64_t seed) {
  TwoSensors sensors(seed);
  NoiseRecursion recursion({.process = true, .memory = memory}, sensors.R, 1.0 / rate, 1e-6);
  for (int k = 0; k < int(duration * rate); ++k) {
    const VectorXd value = sensors.draw();
    const double factor = stated * recursion.process_factor();
    const auto more = sensors.expected(value, sensors.R, factor * std::exp(log_ratio));
    recursion.learn(sensors.expected(value, sensors.R, factor), &more, log_ratio);
  }
  return stated * recursion.process_factor();
}

TEST(NoiseRecursion, FindsTheNoiseOfSensorsFromFarAwayAtAnyRate) {
  const MatrixXd truth = TwoSensors(1).R;
  for (const double rate : {200.0, 2000.0})
    for (const double factor : {0.25, 1.0, 100.0}) {
      const MatrixXd found = learned_noise(factor, rate, 5.0 * memory, 1);
      for (Index i = 0; i < 2; ++i) {
        // A stated noise of less than a tenth of S hardly changes S: what was stated counts more than the samples.
        const double stated_share = factor * truth(i, i) / (factor * truth(i, i) + TwoSensors(1).B(i, i));
        if (stated_share < 0.1) {
          EXPECT_GT(found(i, i), factor * truth(i, i)) << rate << " " << factor;
          EXPECT_LT(found(i, i), truth(i, i)) << rate << " " << factor;
          continue;
        }
        // Of 2 memories of samples about as many tell of the noise as its share of S squared.
        const double share = truth(i, i) / (truth(i, i) + TwoSensors(1).B(i, i));
        const double deviation = std::sqrt(1.0 / (memory * rate)) / share;
        EXPECT_NEAR(std::log(found(i, i) / truth(i, i)), 0.0, 4.0 * deviation + 0.02) << rate << " " << factor;
      }
    }
}

TEST(NoiseRecursion, ForgetsByTimeAndNotBySamples) {
  // From a hundredfold, a memory after the start: the same at both rates.
  double logarithm[2] = {0.0, 0.0};
  for (const int i : {0, 1})
    for (std::uint64_t seed = 1; seed <= 20; ++seed)
      logarithm[i] += std::log(learned_noise(100.0, i == 0 ? 200.0 : 1000.0, memory, seed)(1, 1)) / 20.0;
  EXPECT_NEAR(logarithm[0], logarithm[1], 0.15);
}

TEST(NoiseRecursion, FindsTheProcessNoiseFromFarAwayAtAnyRate) {
  for (const double rate : {200.0, 2000.0})
    for (const double stated : {0.01, 1.0, 100.0})
      EXPECT_NEAR(std::log(learned_factor(stated, rate, 5.0 * memory, 2)), 0.0, 4.0 / std::sqrt(memory * rate) + 0.02)
          << rate << " " << stated;
}

TEST(NoiseRecursion, DoesNotDriftWhereTheNoiseIsRight) {
  double sum = 0.0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed)
    sum += std::log(learned_factor(1.0, 200.0, 5.0 * memory, seed)) / 40.0;
  EXPECT_NEAR(sum, 0.0, 0.05);
}

TEST(NoiseRecursion, StaysPutWhereNoSensorSeesTheProcessNoise) {
  TwoSensors sensors(3);
  NoiseRecursion recursion({.process = true, .memory = memory}, sensors.R, 1e-2, 1e-6);
  for (int k = 0; k < 2000; ++k) {
    const auto innovation = sensors.expected(sensors.draw(), sensors.R, 1.0);
    recursion.learn(innovation, &innovation, log_ratio);
  }
  EXPECT_EQ(recursion.process_factor(), 1.0);
}

TEST(NoiseRecursion, DoesNotCountSingleOutliersButManyOfThem) {
  TwoSensors sensors(4);
  for (const double part : {0.02, 0.6}) {
    NoiseRecursion recursion({.sensors = true, .memory = memory}, sensors.R, 5e-3, 1e-6);
    for (int k = 0; k < 4000; ++k) {
      auto innovation = sensors.expected(sensors.draw(), recursion.measurement_noise(), 1.0);
      if (sensors.random.uniform() < part) {  // the gate has left the second one out
        innovation.set_aside = {{1, 0, 60.0, std::sqrt(innovation.covariance(1, 1)), true}};
        innovation.channels = {0};
        innovation.value.conservativeResize(1);
        innovation.covariance.conservativeResize(1, 1);
      }
      recursion.learn(innovation, nullptr, log_ratio);
    }
    const double found = recursion.measurement_noise()(1, 1) / sensors.R(1, 1);
    if (part < 0.1)
      EXPECT_NEAR(found, 1.0, 0.4);
    else
      EXPECT_GT(found, 20.0);
    EXPECT_NEAR(recursion.measurement_noise()(0, 0), 0.5, 0.3);
  }
}

TEST(NoiseRecursion, LearnsNothingOfChannelsThatAreMissing) {
  TwoSensors sensors(5);
  NoiseRecursion recursion({.sensors = true, .memory = memory}, 0.01 * sensors.R, 5e-3, 1e-6);
  for (int k = 0; k < 2000; ++k) {
    auto innovation = sensors.expected(sensors.draw(), recursion.measurement_noise(), 1.0);
    innovation.channels = {1};
    innovation.value = innovation.value.tail(1).eval();
    innovation.covariance = innovation.covariance.bottomRightCorner(1, 1).eval();
    recursion.learn(innovation, nullptr, log_ratio);
  }
  EXPECT_EQ(recursion.measurement_noise()(0, 0), 0.01 * sensors.R(0, 0));
  EXPECT_NEAR(recursion.measurement_noise()(1, 1), sensors.R(1, 1), 1.0);
  // 2 x 5 samples of the stated noise: a fortieth of the memory, but for the difference of 1 - exp(-a) and a = 0.0025.
  EXPECT_NEAR(recursion.sensor_uncertainty()[0], 0.5 / std::sqrt(5.0), 1e-3);
  EXPECT_LT(recursion.sensor_uncertainty()[1], 0.06);  // share 2/3 of S, half of a memory's 400 samples
}

}  // namespace
}  // namespace kalfem
