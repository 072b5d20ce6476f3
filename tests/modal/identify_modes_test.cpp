// SPDX-License-Identifier: Apache-2.0
#include "kalfem/modal/identify_modes.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "kalfem/base/invalid_input.hpp"
#include "modal/modal_runs.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

// Forty records of five minutes: 320 intervals, of which 99 of 100 counts lie in 294 to 314. A bias of 0.25 deviations
// has a deviation of 0.16 over forty records itself: three of these beside it.
TEST(IdentifyModes, OfAShearFrameHaveHonestDeviations) {
  const auto tally = test::tally_modes(test::shear_frame(8, 20.0, 0.01), 64.0, 19200, 1, 40);
  EXPECT_EQ(tally.missed, 0);
  EXPECT_EQ(tally.spurious, 0);
  EXPECT_TRUE(test::is_binomial(tally.frequencies_held, tally.intervals)) << tally.frequencies_held;
  EXPECT_TRUE(test::is_binomial(tally.dampings_held, tally.intervals)) << tally.dampings_held;
  EXPECT_LT(tally.frequency_bias.cwiseAbs().maxCoeff(), 0.25 + 3.0 * 0.16);
  EXPECT_NEAR(static_cast<double>(tally.shapes_held) / tally.shape_intervals, 0.95, 0.02);
}

TEST(IdentifyModes, ByDataHaveHonestDeviations) {
  const ModalOptions options{.subspace = SubspaceMethod::data};
  const auto tally = test::tally_modes(test::shear_frame(8, 20.0, 0.01), 64.0, 19200, 1, 40, options);
  EXPECT_EQ(tally.missed, 0);
  EXPECT_EQ(tally.spurious, 0);
  EXPECT_TRUE(test::is_binomial(tally.frequencies_held, tally.intervals)) << tally.frequencies_held;
  EXPECT_TRUE(test::is_binomial(tally.dampings_held, tally.intervals)) << tally.dampings_held;
  EXPECT_LT(tally.frequency_bias.cwiseAbs().maxCoeff(), 0.25 + 3.0 * 0.16);
}

// Of a hundred records without a machine, at most one is said to have one: lightly damped, in noise, by both methods.
TEST(IdentifyModes, NamesNoHarmonicWhereThereIsNone) {
  int named = 0;
  for (std::uint64_t seed = 1; seed <= 50; ++seed)
    for (const auto method : {SubspaceMethod::covariance, SubspaceMethod::data}) {
      const auto structure = test::shear_frame(3, 20.0, seed % 2 == 0 ? 0.002 : 0.01);
      const auto found = identify_modes(test::ambient_record(structure, 64.0, 12000, seed, 0.1), {.subspace = method});
      for (const auto& remark : found.remarks) named += remark.find("steady vibration") != std::string::npos;
    }
  EXPECT_LE(named, 1);
}

TEST(IdentifyModes, TakesThePolesThatAPersonChose) {
  const auto structure = test::shear_frame(3, 20.0, 0.01);
  const auto record = test::ambient_record(structure, 64.0, 20000, 4);
  const auto all = identify_modes(record);
  const auto f = structure.frequencies();
  const auto found = identify_modes(record, {.poles = {{f[2], 0}, {f[0], 12}}});
  ASSERT_EQ(found.modes.size(), 2u);
  EXPECT_EQ(found.modes[0].order, 12);
  EXPECT_NEAR(found.modes[0].frequency, f[0], 4.0 * found.modes[0].frequency_std());
  EXPECT_EQ(found.modes[1].order, found.max_order);
  EXPECT_NEAR(found.modes[1].frequency, all.modes[2].frequency, all.modes[2].frequency_std());
  EXPECT_GT(found.modes[1].orders, 5);
}

// A record without noise: almost no combination of past outputs is free of the modes.
TEST(IdentifyModes, ByDataOfARecordWithoutNoise) {
  const auto structure = test::shear_frame(3, 20.0, 0.01);
  const auto found =
      identify_modes(test::ambient_record(structure, 64.0, 40000, 5, 0.0), {.subspace = SubspaceMethod::data});
  ASSERT_EQ(found.modes.size(), 3u);
  for (Index i = 0; i < 3; ++i) {
    const auto& mode = found.modes[static_cast<std::size_t>(i)];
    EXPECT_NEAR(mode.frequency, structure.frequencies()[i], 4.0 * mode.frequency_std());
  }
}

TEST(IdentifyModes, TellsTwoModesApartThatAreHalfAPercentApart) {
  const auto tally = test::tally_modes(test::close_pair(10.0, 0.005, 0.002), 40.0, 8000, 1, 40);
  EXPECT_EQ(tally.missed, 0);
  EXPECT_EQ(tally.spurious, 0);
  EXPECT_TRUE(test::is_binomial(tally.frequencies_held, tally.intervals)) << tally.frequencies_held;
  EXPECT_TRUE(test::is_binomial(tally.dampings_held, tally.intervals)) << tally.dampings_held;
}

TEST(IdentifyModes, FindsAllModesOfANearlySquarePlate) {
  const auto tally = test::tally_modes(test::near_square_plate(5.0, 1.02, 0.01), 128.0, 60000, 1, 2);
  EXPECT_EQ(tally.missed, 0);
  EXPECT_EQ(tally.spurious, 0);
}

TEST(IdentifyModes, WithFewReferencesAndABand) {
  const auto structure = test::shear_frame(8, 20.0, 0.01);
  const auto record = test::ambient_record(structure, 200.0, 120000, 2);
  const auto found = identify_modes(record, {.references = {"v8", "v3"}, .band = FrequencyBand{0.5, 13.0}});
  EXPECT_EQ(found.references, (std::vector<std::string>{"v8", "v3"}));
  EXPECT_LT(found.sample_rate, 40.0);
  ASSERT_EQ(found.modes.size(), 4u);
  for (Index i = 0; i < 4; ++i) {
    const auto& mode = found.modes[static_cast<std::size_t>(i)];
    EXPECT_NEAR(mode.frequency, structure.frequencies()[i], 4.0 * mode.frequency_std());
    EXPECT_GT(mode.phase_collinearity, 0.98);
    ASSERT_TRUE(mode.spectral);  // a peak of a record of 600 s lies within a half-power bandwidth of the mode
    EXPECT_NEAR(mode.spectral->frequency, mode.frequency, 0.02 * mode.frequency);
    EXPECT_GT(mode.spectral->mac, 0.95);
  }
}

TEST(IdentifyModes, AreTheSameWithAnyNumberOfThreads) {
  const auto record = test::ambient_record(test::shear_frame(3, 20.0, 0.01), 64.0, 20000, 4);
  const auto one = identify_modes(record, {.threads = 1}), three = identify_modes(record, {.threads = 3});
  ASSERT_EQ(one.modes.size(), three.modes.size());
  for (std::size_t i = 0; i < one.modes.size(); ++i) {
    EXPECT_EQ(one.modes[i].frequency, three.modes[i].frequency);
    EXPECT_EQ(one.modes[i].shape_covariance, three.modes[i].shape_covariance);
  }
}

TEST(IdentifyModes, ScalesShapesToTheUnitsOfTheChannels) {
  auto record = test::ambient_record(test::shear_frame(3, 20.0, 0.01), 64.0, 20000, 4);
  const auto before = identify_modes(record);
  record.values.row(0) *= 1000.0;
  const auto after = identify_modes(record);
  ASSERT_EQ(before.modes.size(), 3u);
  ASSERT_EQ(after.modes.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(after.modes[i].frequency, before.modes[i].frequency, 1e-9);
    EXPECT_NEAR(std::abs(after.modes[i].shape[0]), 1.0, 1e-12);
    const auto ratio = before.modes[i].shape[1] / before.modes[i].shape[0];
    EXPECT_LT(std::abs(after.modes[i].shape[1] - ratio / 1000.0), 1e-9);
  }
}

// A machine beside the structure: a sine has no damping, of which half would be less than its deviation.
TEST(IdentifyModes, AreNotSteadyHarmonics) {
  const auto structure = test::shear_frame(3, 20.0, 0.01);
  auto record = test::ambient_record(structure, 64.0, 20000, 4);
  const double size = 2.0 * rms(record.values.row(0).transpose());
  for (Index k = 0; k < record.samples(); ++k) {
    const double sine = std::sin(2.0 * M_PI * 7.0 * record.time(k));
    for (Index row = 0; row < 3; ++row) record.values(row, k) += size * sine * (1.0 - 0.6 * static_cast<double>(row));
  }
  const auto found = identify_modes(record);
  ASSERT_EQ(found.modes.size(), 3u);
  ASSERT_EQ(found.remarks.size(), 1u);
  EXPECT_NE(found.remarks[0].find("A steady vibration at 7 Hz"), std::string::npos) << found.remarks[0];
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(found.modes[i].frequency, structure.frequencies()[static_cast<Index>(i)],
                4.0 * found.modes[i].frequency_std());
}

std::string complaint(const Record& record, const ModalOptions& options = {}) {
  try {
    identify_modes(record, options);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

TEST(IdentifyModes, RefusesWhatTellsNoModes) {
  const auto record = test::ambient_record(test::shear_frame(3, 20.0, 0.01), 64.0, 20000, 4);
  EXPECT_NE(complaint(record, {.channels = {"v1"}}).find("1 channel"), std::string::npos);
  EXPECT_NE(complaint(record, {.channels = {"v1", "w2"}}).find("w2"), std::string::npos);
  EXPECT_NE(complaint(record, {.references = {"v9"}}).find("there is no channel 'v9'"), std::string::npos);
  EXPECT_NE(complaint(record, {.band = FrequencyBand{5.0, 40.0}}).find("band"), std::string::npos);
  EXPECT_NE(complaint(record, {.blocks = 3}).find("blocks: 3"), std::string::npos);
  EXPECT_NE(complaint(cut(record, 0.0, 10.0)).find("samples"), std::string::npos);
  EXPECT_NE(complaint(record, {.poles = {{13.0, 2}}}).find("there is no pole at 13 Hz of order 2"), std::string::npos);
  auto dead = record;
  dead.values.row(1).setConstant(0.25);
  EXPECT_NE(complaint(dead).find("'v2' is 0.25 throughout"), std::string::npos);
  auto gap = record;
  gap.values(2, 77) = std::nan("");
  EXPECT_NE(complaint(gap).find("'v3' has 1 missing sample"), std::string::npos);
  auto both = dead;
  both.values(2, 77) = std::nan("");
  EXPECT_NE(complaint(both).find("'v2'"), std::string::npos);
  EXPECT_NE(complaint(both).find("'v3'"), std::string::npos);
}

}  // namespace
}  // namespace kalfem
