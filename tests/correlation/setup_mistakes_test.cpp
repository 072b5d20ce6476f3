// SPDX-License-Identifier: Apache-2.0
#include "kalfem/correlation/setup_mistakes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>

#include "correlation/planted_mistakes.hpp"

namespace kalfem {
namespace {

using namespace test;
using testing::ContainsRegex;
using testing::ElementsAre;

/// A few of the tests that SetupMistakesCalibration makes: 8 of each structure, two of each mistake.
TEST(SetupMistakes, NameTheSensorFirst) {
  MistakeTally tally;
  plant_mistakes(mast(7), 10, 1, 8, tally);
  plant_mistakes(plane_frame(4, 2), 14, 1, 8, tally);
  plant_mistakes(plate(6, 5), 16, 1, 8, tally);
  std::cout << in_words(tally) << "\n";
  EXPECT_GE(tally.right, 22) << in_words(tally);
}

/// What is wrong with the model is no mistake of the set-up.
TEST(SetupMistakes, FindNoneWhereThereIsNone) {
  MistakeTally tally;
  count_alarms(mast(7), 10, 1, 8, tally);
  count_alarms(plane_frame(4, 2), 14, 1, 8, tally);
  count_alarms(plate(6, 5), 16, 1, 8, tally);
  EXPECT_LE(tally.alarms, 1);
}

/// Two at once, of which the second is found once the first is mended.
TEST(SetupMistakes, TwoAtOnceAreBothFound) {
  ModalTest test(mast(7), 10, 3);
  test.measured.row(4) *= -1.0;
  test.measured.row(11).swap(test.measured.row(20));
  const auto mistakes = test.correlated().mistakes;
  ASSERT_EQ(mistakes.size(), 2U);
  std::vector<std::string> words = {mistakes[0].in_words(), mistakes[1].in_words()};
  std::ranges::sort(words);
  EXPECT_THAT(words, ElementsAre("a12 and a21 are swapped", "a5 is turned: it measures against its direction"));
  EXPECT_GT(mistakes[1].mac_after, mistakes[0].mac_before + 0.05);
}

/// The sensors of the first node that has so many, turned by 90 degrees about z: x reads y, y reads -x.
std::string rotation_found(ModalTest test, std::size_t axes) {
  std::vector<Eigen::Index> node;
  for (Eigen::Index i = 0; node.size() != axes; ++i) node = test.sensors_of_node(i);
  test.measured.row(node[0]).swap(test.measured.row(node[1]));
  test.measured.row(node[1]) *= -1.0;
  const auto mistakes = test.correlated().mistakes;
  if (mistakes.empty() || mistakes[0].kind != MistakeKind::rotated) return "";
  EXPECT_EQ(mistakes[0].sensors.size(), axes);
  for (std::size_t i = 0; i < axes && i < mistakes[0].sensors.size(); ++i)
    EXPECT_EQ(mistakes[0].sensors[i], test.sensors[static_cast<std::size_t>(node[i])].name);
  return mistakes[0].in_words();
}

TEST(SetupMistakes, ARotationIsStated) {
  // Up to 3 degrees off: the noise, and a model whose bars are off by up to 10 %.
  EXPECT_THAT(rotation_found({mast(7), 10, 5}, 3),
              ContainsRegex("a[0-9]+, a[0-9]+ and a[0-9]+ are rotated together, by (8[7-9]|9[0-3]) degrees about "));
  EXPECT_THAT(rotation_found({plane_frame(4, 2), 14, 5}, 2),
              ContainsRegex("a[0-9]+ and a[0-9]+ are rotated together, by (8[7-9]|9[0-3]) degrees in their plane"));
}

}  // namespace
}  // namespace kalfem
