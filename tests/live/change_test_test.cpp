// SPDX-License-Identifier: Apache-2.0
#include "kalfem/live/change_test.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "kalfem/live/change_threshold.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Windows of three parameters whose estimates are correlated, and follow a temperature.
struct Windows {
  explicit Windows(unsigned seed, double scatter = 1.0) : random(seed), scatter(scatter) {
    information << 4e4, 1e4, 0, 1e4, 9e4, -2e4, 0, -2e4, 3e4;
    root = information.inverse().llt().matrixL();
  }

  /// The next window, a minute long, with a step of the second parameter.
  void add(double temperature, double step) {
    VectorXd estimate = VectorXd::Constant(3, 0.01) + temperature * VectorXd::LinSpaced(3, -4e-4, -6e-4);
    estimate[1] += step;
    VectorXd noise(3);
    for (double& each : noise) each = normal(random);
    estimate += std::sqrt(scatter) * root * noise;
    test.add(60.0 * double(test.windows()), {information, information * estimate},
             VectorXd::Constant(1, 290.0 + temperature),
             test.windows() < 60 ? ScatterLearning::fully : ScatterLearning::limited);
  }

  std::mt19937_64 random;
  std::normal_distribution<double> normal;
  double scatter;
  MatrixXd information = MatrixXd(3, 3), root;
  ChangeTest test{VectorXd::Constant(3, 0.1), VectorXd::Constant(1, 0.01), 30};
};

double day(int window) { return 20.0 * std::sin(2.0 * std::numbers::pi * window / 240.0); }

ParameterStep largest(const ChangeTest& test) {
  const auto steps = test.likely_steps();
  return *std::ranges::max_element(steps, {}, &ParameterStep::statistic);
}

TEST(ChangeTest, FindsAStepBeneathTheTemperature) {
  Windows windows(1);
  for (int w = 0; w < 300; ++w) windows.add(day(w), 0.0);
  EXPECT_LT(largest(windows.test).statistic, change_threshold(18'000, 30, 3));
  for (int w = 300; w < 310; ++w) windows.add(day(w), -0.015);
  const auto step = largest(windows.test);
  EXPECT_GT(step.statistic, change_threshold(18'000, 30, 3));
  EXPECT_EQ(step.parameter, 1);
  EXPECT_NEAR(step.change, -0.015, 4.0 * step.deviation);
  EXPECT_LE(step.earliest, 300 * 60.0);
  EXPECT_GE(step.latest, 300 * 60.0);
  windows.test.accept(step);
  for (int w = 310; w < 400; ++w) windows.add(day(w), -0.015);
  const auto total = windows.test.total_change(1);
  EXPECT_NEAR(total.change, -0.015, 3.0 * total.deviation);
  EXPECT_LT(total.deviation, 0.4 * step.deviation);
  EXPECT_LT(largest(windows.test).statistic, change_threshold(18'000, 30, 3));
  EXPECT_LT((windows.test.effects() - VectorXd::LinSpaced(3, -4e-4, -6e-4)).cwiseAbs().maxCoeff(), 1e-4);
}

/// Steps whose bands hold the truth, and deviations as stated, over many seeds.
TEST(ChangeTest, StatesItsDeviations) {
  double squares = 0.0;
  constexpr int seeds = 100;
  for (unsigned seed = 0; seed < seeds; ++seed) {
    Windows windows(seed);
    for (int w = 0; w < 100; ++w) windows.add(day(w), 0.0);
    ParameterStep step{.parameter = 1, .since = 100 * 60.0};
    for (int w = 100; w < 110; ++w) windows.add(day(w), -0.004);
    windows.test.accept(step);
    const auto total = windows.test.total_change(1);
    squares += std::pow((total.change + 0.004) / total.deviation, 2) / seeds;
  }
  EXPECT_NEAR(squares, 1.0, 0.45);
}

/// A change of temperature that has not been seen before may be the cause: no alarm.
TEST(ChangeTest, DoesNotBlameTheStructureForATemperatureThatItDoesNotKnow) {
  Windows windows(2);
  for (int w = 0; w < 60; ++w) windows.add(0.0, 0.0);
  for (int w = 0; w < 10; ++w) windows.add(30.0, 0.0);
  EXPECT_LT(largest(windows.test).statistic, change_threshold(18'000, 30, 3));
}

TEST(ChangeTest, LearnsThatWindowsScatterMoreThanStated) {
  Windows stated(3), wider(3, 9.0);
  for (int w = 0; w < 300; ++w) {
    stated.add(day(w), 0.0);
    wider.add(day(w), 0.0);
  }
  EXPECT_NEAR(stated.test.scatter(), 1.0, 0.15);
  EXPECT_NEAR(wider.test.scatter(), 9.0, 1.5);
}

/// One alarm in the stated time: of forty such times, each begun anew after an alarm.
TEST(ChangeTest, GivesNoMoreFalseAlarmsThanStated) {
  constexpr int stated = 600, times = 40;
  const double threshold = change_threshold(stated, 30, 3);
  int alarms = 0;
  for (unsigned seed = 0; seed < times; ++seed) {
    Windows windows(100 + seed);
    for (int w = 0; w < 60; ++w) windows.add(day(w), 0.0);
    for (int w = 60; w < 60 + stated; ++w) {
      windows.add(day(w), 0.0);
      if (!(largest(windows.test).statistic > threshold)) continue;
      ++alarms;
      break;
    }
  }
  EXPECT_LE(alarms, 34);  // 1 - 1/e of them is 25
  EXPECT_GE(alarms, 10);
}

}  // namespace
}  // namespace kalfem
