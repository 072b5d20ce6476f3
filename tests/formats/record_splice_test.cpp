// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/record_splice.hpp"
#include "base/absent.hpp"

#include <gtest/gtest.h>
#include <cmath>
#include <limits>
#include <random>

#include "formats/measured_record.hpp"
#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr double no_value = std::numeric_limits<double>::quiet_NaN();

/// Two decaying oscillations of 1.5 and 2.2 Hz and a small one of 9 Hz.
double motion(Index channel, double time) {
  const double rate = channel == 0 ? 9.4 : channel == 1 ? 13.8 : 56.0, size = channel == 2 ? 0.002 : 0.03;
  return size * std::exp(-0.4 * time) * std::cos(rate * time + 0.3 * static_cast<double>(channel));
}

/// A record at 500 Hz that is quiet up to sample `change` and noisy from there on, where its time jumps by `missing`.
Record record_with(Index change, double missing, double quiet = 2e-7, double noisy = 1e-5, unsigned seed = 3) {
  Record record;
  record.sample_rate = 500.0;
  record.start = 2.0;
  record.channels = {{"left", "m"}, {"right", "m"}, {"wheel", "m"}};
  record.values.resize(3, 1500);
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  for (Index k = 0; k < 1500; ++k)
    for (Index c = 0; c < 3; ++c) {
      const double shifted = static_cast<double>(k) + (k < change ? 0.0 : missing);
      record.values(c, k) = motion(c, shifted / 500.0) + (k < change ? quiet : noisy) * normal(generator);
    }
  return record;
}

TEST(FindSplice, FindsPlaceAndNumberOfMissingSamples) {
  for (const double missing : {1.0, 4.0, 9.0, 15.0}) {
    const auto splice = find_splice(record_with(400, missing));
    ASSERT_TRUE(splice) << missing;
    // The largest second difference stands on one of the two samples between which the time jumps.
    EXPECT_NEAR(static_cast<double>(splice->sample), 400.0, 1.0);
    EXPECT_EQ(splice->inserted, static_cast<Index>(missing));
    EXPECT_NEAR(splice->missing, missing, 0.11);  // a step of the search is .1 samples
    EXPECT_DOUBLE_EQ(splice->time, 2.0 + static_cast<double>(splice->sample) / 500.0);
  }
}

TEST(FindSplice, ReportsTheNoiseOfBothParts) {
  const auto splice = find_splice(record_with(400, 4.0));
  ASSERT_TRUE(splice);
  // 1100 samples tell it to some per cent: found 4 %
  for (const auto& channel : splice->evidence) EXPECT_NEAR(channel.noise_after, 1e-5, 1e-6) << channel.channel;
  EXPECT_NE(to_string(*splice).find("4 missing samples inserted"), std::string::npos) << to_string(*splice);
  EXPECT_NE(to_string(*splice).find("wheel"), std::string::npos);
}

/// The same bench at ten times the rate: 40 samples are missing at 5 kHz, and each tells less of the motion.
TEST(FindSplice, FollowsTheMotionAtAnyRate) {
  Record record;
  record.sample_rate = 5000.0;
  record.channels = {{"left", "m"}, {"right", "m"}};
  record.values.resize(2, 15000);
  std::mt19937 generator(5);
  std::normal_distribution<double> normal;
  for (Index k = 0; k < 15000; ++k)
    for (Index c = 0; c < 2; ++c)
      record.values(c, k) = motion(c, static_cast<double>(k + (k < 4000 ? 0 : 40)) / 5000.0) +
                            (k < 4000 ? 2e-7 : 1e-4) * normal(generator);
  const auto splice = find_splice(record);
  ASSERT_TRUE(splice);
  EXPECT_NEAR(static_cast<double>(splice->sample), 4000.0, 2.0);
  EXPECT_NEAR(splice->missing, 40.0, 3.0);  // three deviations of the two channels together
}

TEST(FindSplice, FindsAnEndOfNoiseToo) {
  const auto splice = find_splice(record_with(700, 4.0, 1e-5, 2e-7));
  ASSERT_TRUE(splice);
  EXPECT_EQ(splice->inserted, 4);
}

TEST(FindSplice, LeavesARecordWithoutSpliceAlone) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    EXPECT_FALSE(find_splice(record_with(1500, 0.0, 1e-5, 1e-5, seed))) << "noise alone, seed " << seed;
    EXPECT_FALSE(find_splice(record_with(400, 0.0, 2e-7, 1e-5, seed))) << "more noise but no jump, seed " << seed;
  }
}

/// Channels that jump by different times, none with half of what is known, were not spliced: something moved.
TEST(FindSplice, SaysNothingWhereTheChannelsDoNotAgree) {
  auto record = record_with(400, 3.0);
  record.values.row(1) = record_with(400, 14.0, 2e-7, 1e-5, 4).values.row(0);
  record.values.row(2) = record_with(400, 8.0, 2e-7, 1e-5, 5).values.row(0);
  EXPECT_FALSE(find_splice(record));
  record.values.row(1) = record_with(400, 3.0, 2e-7, 1e-5, 4).values.row(0);
  EXPECT_TRUE(find_splice(record));
}

/// Straight motions that jump by four samples: seen where the jump stands out of the noise, and not where it is of the
/// noise's own size.
TEST(FindSplice, AsksForAJumpBeyondTheNoise) {
  const auto with_speed = [](double speed) {
    auto record = record_with(1500, 0.0);
    std::mt19937 generator(3);
    std::normal_distribution<double> normal;
    for (Index k = 0; k < 1500; ++k)
      for (Index c = 0; c < 3; ++c)
        record.values(c, k) =
            speed * (1.0 + 0.1 * static_cast<double>(c)) * static_cast<double>(k < 400 ? k : k + 4) / 500.0 +
            (k < 400 ? 2e-7 : 1e-5) * normal(generator);
    return record;
  };
  EXPECT_TRUE(find_splice(with_speed(0.05)));    // 0.4 mm, forty deviations
  EXPECT_FALSE(find_splice(with_speed(0.005)));  // four
}

TEST(FindSplice, TakesNoReleaseForASplice) {
  for (const double frequency : {2.0, 10.0, 40.0, 90.0})
    for (const double noise : {0.0, 1e-7, 1e-5}) {
      auto record = record_with(1500, 0.0);
      std::mt19937 generator(11);
      std::normal_distribution<double> normal;
      for (Index k = 0; k < 1500; ++k)
        for (Index c = 0; c < 3; ++c) {
          const double time = std::max(0.0, static_cast<double>(k - 300) / 500.0);
          record.values(c, k) =
              0.03 * std::exp(-2.0 * time) * std::cos(6.28 * frequency * (1.0 + 0.2 * static_cast<double>(c)) * time) +
              noise * normal(generator);
        }
      EXPECT_FALSE(find_splice(record)) << frequency << " Hz, noise " << noise;
    }
}

TEST(FindSplice, TakesNoBlowForASplice) {
  auto record = record_with(1500, 0.0, 2e-7, 2e-7);
  for (Index k = 500; k < 1500; ++k)
    for (Index c = 0; c < 3; ++c) {
      const double time = static_cast<double>(k - 500) / 500.0;
      record.values(c, k) +=
          1e-3 * std::exp(-5.0 * time) * std::sin(500.0 * (1.0 + 0.1 * static_cast<double>(c)) * time);
    }
  EXPECT_FALSE(find_splice(record));
}

TEST(FindSplice, IgnoresChannelsThatSayNothingAndMissingSamples) {
  auto record = record_with(400, 4.0);
  record.values.conservativeResize(4, Eigen::NoChange);
  record.values.row(3).setConstant(0.7);
  record.values.col(120).setConstant(no_value);
  record.values(1, 405) = no_value;
  const auto splice = find_splice(record);
  ASSERT_TRUE(splice);
  EXPECT_EQ(splice->inserted, 4);
}

TEST(FindSplice, SurvivesDegenerateRecords) {
  Record record;
  EXPECT_FALSE(find_splice(record));
  record.values = MatrixXd::Zero(2, 500);
  EXPECT_FALSE(find_splice(record));
  record.values.setConstant(no_value);
  EXPECT_FALSE(find_splice(record));
  record.values.setConstant(std::numeric_limits<double>::infinity());
  EXPECT_FALSE(find_splice(record));
}

TEST(FindSplice, RefusesOptionsOutOfRange) {
  const auto record = record_with(400, 4.0);
  EXPECT_THROW((void)find_splice(record, {.noise_ratio = no_value}), InvalidInput);
  EXPECT_THROW((void)find_splice(record, {.shortest = 0}), InvalidInput);
  EXPECT_THROW((void)find_splice(record, {.before = 2}), InvalidInput);
  EXPECT_THROW((void)find_splice(record, {.degree = 0}), InvalidInput);
  EXPECT_THROW((void)find_splice(record, {.largest = 0}), InvalidInput);
  EXPECT_THROW((void)find_splice(record, {.blanked = -1}), InvalidInput);
}

TEST(Mend, RestoresTheTimesOfTheSecondPart) {
  const auto record = record_with(400, 4.0, 0.0, 1e-5);
  const auto splice = find_splice(record);
  ASSERT_TRUE(splice);
  const auto mended = mend(record, *splice);
  ASSERT_EQ(mended.samples(), record.samples() + 4);
  Index missing = 0;
  for (Index k = 0; k < mended.samples(); ++k) {
    if (std::isnan(mended.values(0, k))) {
      ++missing;
      EXPECT_TRUE(mended.values.col(k).array().isNaN().all());
      continue;
    }
    for (Index c = 0; c < 3; ++c)  // six standard deviations of the noise
      EXPECT_NEAR(mended.values(c, k), motion(c, static_cast<double>(k) / 500.0), 6e-5);
  }
  EXPECT_EQ(missing, 4 + 5);
  EXPECT_FALSE(find_splice(mended)) << "a mended record needs no more mending";
}

TEST(Mend, RefusesASpliceOfAnotherRecord) {
  Splice splice;
  splice.sample = 5000;
  EXPECT_THROW((void)mend(record_with(400, 4.0), splice), InvalidInput);
}

TEST(FindSplice, FindsFourMissingSamplesInEveryMeasuredRun) {
  const auto runs = measured_runs();
  if (runs.empty()) KALFEM_ABSENT("no measured records at " + measured_runs_folder().string());
  // Sample of the jump, read off the records' second differences by eye.
  const std::vector<Index> jump = {429, 483, 287, 276, 372, 298};
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const auto splice = find_splice(runs[i].record);
    ASSERT_TRUE(splice) << runs[i].key;
    EXPECT_EQ(splice->inserted, 4) << runs[i].key << ": " << to_string(*splice);
    EXPECT_LE(std::abs(splice->sample - jump[i]), 1) << runs[i].key;
    EXPECT_FALSE(find_splice(mend(runs[i].record, *splice))) << runs[i].key;
  }
}

}  // namespace
}  // namespace kalfem
