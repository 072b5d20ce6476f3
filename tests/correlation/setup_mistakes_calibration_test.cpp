// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <iostream>

#include "correlation/planted_mistakes.hpp"

/// KALFEM_FIRST and KALFEM_COUNT choose the seeds; all are 100.
namespace kalfem::test {
namespace {

int number(const char* name, int otherwise) {
  const char* text = std::getenv(name);
  return text ? std::atoi(text) : otherwise;
}

void expect_named(const TestedStructure& structure, int nodes) {
  MistakeTally tally;
  const int first = number("KALFEM_FIRST", 1), count = number("KALFEM_COUNT", 100);
  plant_mistakes(structure, nodes, first, count, tally);
  count_alarms(structure, nodes, first, count, tally);
  std::cout << in_words(tally) << std::endl;
  EXPECT_GE(tally.right, std::floor(0.9 * tally.tests));
  EXPECT_LE(tally.alarms, std::ceil(0.05 * tally.set_ups));
}

TEST(SetupMistakesCalibration, OfAMast) { expect_named(mast(7), 10); }
TEST(SetupMistakesCalibration, OfAPlaneFrame) { expect_named(plane_frame(4, 2), 14); }
TEST(SetupMistakesCalibration, OfAPlate) { expect_named(plate(6, 5), 16); }

}  // namespace
}  // namespace kalfem::test
