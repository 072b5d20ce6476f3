// SPDX-License-Identifier: Apache-2.0
// A frame that was measured in several set-ups, two of its sensors in all of them.
#include "kalfem/modal/merge_setups.hpp"

#include <gtest/gtest.h>

#include <cstdio>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/modal/identify_modes.hpp"
#include "kalfem/modal/shape_measures.hpp"
#include "modal/ambient_record.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

/// A record of some floors alone.
Record floors_of(const Record& record, const std::vector<Index>& floors) {
  Record part = record;
  part.channels.clear();
  part.values.resize(std::ssize(floors), record.values.cols());
  for (std::size_t i = 0; i < floors.size(); ++i) {
    part.channels.push_back(record.channels[static_cast<std::size_t>(floors[i])]);
    part.values.row(static_cast<Index>(i)) = record.values.row(floors[i]);
  }
  return part;
}

struct MergedFrame : testing::Test {
  static constexpr int storeys = 6;
  const test::AmbientStructure structure = test::shear_frame(storeys, 20.0, 0.01);
  const std::vector<std::vector<Index>> floors = {{2, 5, 0}, {2, 5, 1, 3}, {5, 4, 2}};

  [[nodiscard]] std::vector<SetupModes> setups(std::uint64_t seed) const {
    std::vector<SetupModes> all;
    for (std::size_t i = 0; i < floors.size(); ++i) {
      const auto record = test::ambient_record(structure, 64.0, 20000, seed + i);
      all.push_back({"setup" + std::to_string(i + 1), identify_modes(floors_of(record, floors[i]), {.threads = 1})});
    }
    return all;
  }
  /// Row of a merged channel in the structure's shapes.
  [[nodiscard]] std::vector<Index> floors_of_channels(const ModalResult& merged) const {
    const auto record = test::ambient_record(structure, 64.0, 64, 1);
    std::vector<Index> rows;
    for (const auto& channel : merged.channels) rows.push_back(record.find(channel));
    return rows;
  }
};

TEST_F(MergedFrame, HasTheShapesOfTheWholeStructure) {
  int within = 0, entries = 0;
  for (std::uint64_t seed = 11; seed < 131; seed += 10) {
    const auto merged = merge_setups(setups(seed));
    ASSERT_EQ(merged.channels.size(), 6u);
    ASSERT_EQ(merged.references.size(), 2u);
    const auto rows = floors_of_channels(merged);
    ASSERT_GE(merged.modes.size(), 5u);
    for (const auto& mode : merged.modes) {
      Index nearest = 0;
      (structure.frequencies().array() - mode.frequency).abs().minCoeff(&nearest);
      // one of 72 frequencies beyond 4.5 deviations in 2000 such tests, of Student's t a few times as often
      EXPECT_NEAR(mode.frequency, structure.frequencies()[nearest], 4.5 * mode.frequency_std());
      Eigen::VectorXcd truth = structure.shapes.col(nearest)(rows).cast<std::complex<double>>();
      EXPECT_GT(mac(mode.shape, truth), 0.998) << mode.frequency;
      Index top = 0;
      mode.shape.cwiseAbs().maxCoeff(&top);
      truth /= truth[top];
      const auto deviation = mode.shape_std();
      for (Index i = 0; i < truth.size(); ++i) {
        if (i == top) continue;
        ++entries;
        within += std::abs(mode.shape[i].real() - truth[i].real()) <= mode.coverage_factor() * deviation[i].real();
      }
    }
  }
  std::printf("%d of %d entries within their 95 %% intervals\n", within, entries);
  // 95 % of 360 entries, of which those of a mode and set-up move together
  EXPECT_GE(within, 0.91 * entries);
  EXPECT_LE(within, 0.99 * entries);
}

TEST_F(MergedFrame, IsSurerOfItsPolesThanOneSetUp) {
  const auto all = setups(21);
  const auto merged = merge_setups(all);
  for (const auto& mode : merged.modes)
    for (const auto& alone : all.front().result.modes)
      if (std::abs(alone.frequency / mode.frequency - 1.0) < 0.01) {
        EXPECT_LT(mode.covariance(0, 0), 1.5 * alone.covariance(0, 0));
      }
}

// Two copies of one set-up of which one is turned and scaled: the merged shape is the same, and so is what is known.
TEST_F(MergedFrame, DoesNotSeeTheScaleOfASetUp) {
  const auto first = setups(11).front();
  auto turned = first;
  turned.name = "turned";
  const std::complex<double> factor(-0.3, 2.0);
  for (auto& mode : turned.result.modes) {
    const Index n = mode.shape.size();
    mode.shape *= factor;
    Eigen::MatrixXd turn(2 * n, 2 * n);
    turn << factor.real() * Eigen::MatrixXd::Identity(n, n), -factor.imag() * Eigen::MatrixXd::Identity(n, n),
        factor.imag() * Eigen::MatrixXd::Identity(n, n), factor.real() * Eigen::MatrixXd::Identity(n, n);
    mode.shape_covariance = turn * mode.shape_covariance * turn.transpose();
  }
  const auto same = merge_setups({first, first}, {.references = first.result.channels});
  const auto merged = merge_setups({first, turned}, {.references = first.result.channels});
  ASSERT_EQ(merged.modes.size(), first.result.modes.size());
  for (std::size_t i = 0; i < merged.modes.size(); ++i) {
    EXPECT_LT((merged.modes[i].shape - first.result.modes[i].shape).norm(), 1e-9);
    // rounding of the central differences
    EXPECT_LT((merged.modes[i].shape_covariance - same.modes[i].shape_covariance).norm(),
              1e-6 * same.modes[i].shape_covariance.norm());
    // two independent set-ups that agree: half the variance of one
    EXPECT_NEAR(merged.modes[i].covariance(0, 0), 0.5 * first.result.modes[i].covariance(0, 0), 1e-12);
  }
}

TEST_F(MergedFrame, TellsApartChannelsOfOneName) {
  auto all = setups(11);
  all[0].result.channels[2] = "moved";
  all[1].result.channels[2] = "moved";
  const auto merged = merge_setups({all[0], all[1]});
  EXPECT_EQ(std::ranges::count(merged.channels, "moved"), 1);  // both set-ups have it: it stands for a reference
  const auto stated =
      merge_setups({all[0], all[1]}, {.references = {all[0].result.channels[0], all[0].result.channels[1]}});
  EXPECT_EQ(stated.channels[2], "setup1:moved");
  EXPECT_EQ(stated.channels[3], "setup2:moved");
}

TEST_F(MergedFrame, RefusesWhatCannotBeMerged) {
  const auto all = setups(11);
  EXPECT_THROW(merge_setups({all[0]}), InvalidInput);
  EXPECT_THROW(merge_setups(all, {.references = {"nowhere"}}), InvalidInput);
  auto apart = all;
  for (auto& channel : apart[1].result.channels) channel += "'";
  EXPECT_THROW(merge_setups(apart), InvalidInput);
}

TEST_F(MergedFrame, LeavesOutAModeThatASetUpLacks) {
  auto all = setups(11);
  const auto count = merge_setups(all).modes.size();
  all[1].result.modes.erase(all[1].result.modes.begin());
  const auto merged = merge_setups(all);
  EXPECT_EQ(merged.modes.size(), count - 1);
  EXPECT_NE(merged.remarks.back().find("is left out: setup2"), std::string::npos) << merged.remarks.back();
}

}  // namespace
}  // namespace kalfem
