// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <cstdlib>
#include <iostream>

#include "modal/modal_runs.hpp"

namespace kalfem {
namespace {

int records() {
  const char* text = std::getenv("KALFEM_COUNT");
  return text ? std::atoi(text) : 200;
}

// KALFEM_COUNT: fewer records, or more.
void expect_honest(const char* name, const test::ModalTally& tally) {
  std::cout << fmt::format(
      "{}: {} records, {} modes found, {} missed, {} spurious, held: frequencies {:.4f}, dampings "
      "{:.4f}, shapes {:.4f}; largest bias: frequency {:.2f}, damping {:.2f} deviations\n",
      name, tally.records, tally.intervals, tally.missed, tally.spurious,
      static_cast<double>(tally.frequencies_held) / tally.intervals,
      static_cast<double>(tally.dampings_held) / tally.intervals,
      static_cast<double>(tally.shapes_held) / tally.shape_intervals, tally.frequency_bias.cwiseAbs().maxCoeff(),
      tally.damping_bias.cwiseAbs().maxCoeff());
  EXPECT_EQ(tally.missed, 0);
  EXPECT_LE(tally.spurious, tally.records / 100);
  EXPECT_TRUE(test::is_binomial(tally.frequencies_held, tally.intervals)) << tally.frequencies_held;
  EXPECT_TRUE(test::is_binomial(tally.dampings_held, tally.intervals)) << tally.dampings_held;
  EXPECT_LT(tally.frequency_bias.cwiseAbs().maxCoeff(), 0.25);
}

TEST(ModalCoverage, OfAShearFrame) {
  expect_honest("frame", test::tally_modes(test::shear_frame(8, 20.0, 0.01), 64.0, 38400, 1, records()));
}

TEST(ModalCoverage, OfAShearFrameByData) {
  expect_honest("frame by data", test::tally_modes(test::shear_frame(8, 20.0, 0.01), 64.0, 38400, 1, records(),
                                                   {.subspace = SubspaceMethod::data}));
}

TEST(ModalCoverage, OfANearlySquarePlate) {
  expect_honest("plate", test::tally_modes(test::near_square_plate(5.0, 1.02, 0.01), 128.0, 100000, 1, records()));
}

// 2,000 periods; the decays of the two modes last for 80 of them.
TEST(ModalCoverage, OfTwoModesHalfAPercentApart) {
  expect_honest("pair", test::tally_modes(test::close_pair(10.0, 0.005, 0.002), 40.0, 8000, 1, records()));
}

}  // namespace
}  // namespace kalfem
