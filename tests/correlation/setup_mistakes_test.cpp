// SPDX-License-Identifier: Apache-2.0
#include "kalfem/correlation/setup_mistakes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <random>

#include "correlation/mast.hpp"
#include "kalfem/correlation/correlate.hpp"

namespace kalfem {
namespace {

using namespace test;
using Eigen::Index;
using Eigen::MatrixXd;
using testing::ElementsAre;
using testing::HasSubstr;

/// A test of the mast at ten joints, 30 sensors: its bars are up to 10 % softer or stiffer than the model's, and the
/// shapes of its ten lowest modes have noise of 2 % of their largest entry.
struct Trial {
  explicit Trial(unsigned seed) : random(seed) {
    const Mast bars = mast(7);
    std::uniform_real_distribution<double> off(0.9, 1.1);
    std::vector<double> factors(bars.bars.size());
    for (auto& factor : factors) factor = off(random);
    model = model_of(bars);
    const auto truth = model_of(bars, factors);
    all = lowest_normal_modes(truth, {.count = 10});
    std::vector<int> joints(21);
    for (int i = 0; i < 21; ++i) joints[static_cast<std::size_t>(i)] = i;
    std::ranges::shuffle(joints, random);
    joints.resize(10);
    for (const int joint : joints)
      for (int axis = 0; axis < 3; ++axis) rows.push_back(3 * joint + axis);
    for (std::size_t i = 0; i < rows.size(); ++i)
      sensors.push_back({"a" + std::to_string(i + 1), model.dofs[static_cast<std::size_t>(rows[i])]});
    measured = all.shapes(rows, Eigen::all);
  }

  [[nodiscard]] std::vector<SetupMistake> found() {
    std::normal_distribution<double> noise;
    std::vector<MeasuredMode> modes;
    for (Index i = 0; i < measured.cols(); ++i) {
      Eigen::VectorXd shape = measured.col(i);
      const double size = 0.02 * shape.cwiseAbs().maxCoeff();
      for (auto& entry : shape) entry += size * noise(random);
      modes.push_back({.frequency = all.frequencies[i], .deviation = 1.0, .shape = shape});
    }
    std::vector<DofCombination> points;
    for (const auto& sensor : sensors) points.push_back({{sensor.place, 1.0}});
    return correlate(modes, points, sensors, model).mistakes;
  }

  int any(int below) { return std::uniform_int_distribution<int>(0, below - 1)(random); }

  std::mt19937 random;
  LinearModel model;
  NormalModes all;
  std::vector<Index> rows;
  std::vector<ShapeSensor> sensors;
  MatrixXd measured;
};

bool names(const SetupMistake& mistake, const std::string& sensor) {
  return std::ranges::find(mistake.sensors, sensor) != mistake.sensors.end();
}

/// Of 100 mistakes the sensor is named first in 90 and more.
TEST(SetupMistakes, NameTheSensorFirst) {
  std::map<std::string, int> named, kinds, planted;
  for (unsigned seed = 1; seed <= 100; ++seed) {
    Trial trial(seed);
    const auto i = static_cast<Index>(trial.any(30)), node = i / 3;
    std::string what, sensor = trial.sensors[static_cast<std::size_t>(i)].name;
    MistakeKind kind{};
    if (seed % 4 == 0) {
      what = "turned", kind = MistakeKind::turned;
      trial.measured.row(i) *= -1.0;
    } else if (seed % 4 == 1) {
      what = "swapped", kind = MistakeKind::swapped;
      const auto j = (i + 1 + trial.any(29)) % 30;
      trial.measured.row(i).swap(trial.measured.row(j));
    } else if (seed % 4 == 2) {
      what = "rotated", kind = MistakeKind::rotated;
      const Eigen::Vector3d axis = Eigen::Vector3d::Unit(trial.any(3));
      const Eigen::Matrix3d turn(Eigen::AngleAxisd(0.5 * M_PI * (1 + trial.any(3)), axis));
      trial.measured.middleRows<3>(3 * node) = (turn * trial.measured.middleRows<3>(3 * node)).eval();
    } else {
      what = "wrong node", kind = MistakeKind::node;
      const Index other = (trial.rows[static_cast<std::size_t>(i)] + 3 * (1 + trial.any(20))) % 63;
      trial.measured.row(i) = trial.all.shapes.row(other);
    }
    const auto mistakes = trial.found();
    ++planted[what];
    if (mistakes.empty()) continue;
    const bool right =
        what == "rotated"
            ? std::ranges::any_of(std::array{0, 1, 2},
                                  [&](int axis) {
                                    return names(mistakes[0],
                                                 trial.sensors[static_cast<std::size_t>(3 * node + axis)].name);
                                  })
            : names(mistakes[0], sensor);
    named[what] += right;
    kinds[what] += right && mistakes[0].kind == kind;
  }
  int all = 0;
  for (const auto& [what, count] : planted) {
    std::cout << what << ": named first in " << named[what] << " of " << count << ", with its cause in " << kinds[what]
              << "\n";
    all += named[what];
  }
  EXPECT_GE(all, 90);
}

/// What is wrong with the model is no mistake of the set-up.
TEST(SetupMistakes, FindNoneWhereThereIsNone) {
  int found = 0;
  for (unsigned seed = 1; seed <= 100; ++seed) found += !Trial(1000 + seed).found().empty();
  std::cout << "mistakes named in " << found << " of 100 right set-ups\n";
  EXPECT_LE(found, 2);
}

/// Two at once, of which the second is found once the first is mended.
TEST(SetupMistakes, TwoAtOnceAreBothFound) {
  Trial trial(3);
  trial.measured.row(4) *= -1.0;
  trial.measured.row(11).swap(trial.measured.row(20));
  const auto mistakes = trial.found();
  ASSERT_EQ(mistakes.size(), 2U);
  std::vector<std::string> words = {mistakes[0].in_words(), mistakes[1].in_words()};
  std::ranges::sort(words);
  EXPECT_THAT(words, ElementsAre("a12 and a21 are swapped", "a5 is turned: it measures against its direction"));
  EXPECT_GT(mistakes[1].mac_after, mistakes[0].mac_before + 0.05);
}

/// The three of a joint turned by 90 degrees about z: x reads y, y reads -x.
TEST(SetupMistakes, ARotationIsStated) {
  Trial trial(5);
  const MatrixXd before = trial.measured;
  trial.measured.row(6) = before.row(7);
  trial.measured.row(7) = -before.row(6);
  const auto mistakes = trial.found();
  ASSERT_FALSE(mistakes.empty());
  EXPECT_EQ(mistakes[0].kind, MistakeKind::rotated);
  EXPECT_THAT(mistakes[0].in_words(), HasSubstr("a7, a8 and a9 are rotated together"));
}

}  // namespace
}  // namespace kalfem
