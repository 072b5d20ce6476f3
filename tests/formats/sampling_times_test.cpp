// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "base/scratch_folder.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/random.hpp"
#include "kalfem/formats/record_file.hpp"
#include "kalfem/records/common_grid.hpp"

// Channels with sampling rates of their own, times that jitter, and rows out of order.
namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

SampleTimes even(double rate, Index count, double start = 0.0) {
  return {.start = start, .interval = 1.0 / rate, .count = count};
}

SampleTimes uneven(const VectorXd& times) { return {.start = times[0], .times = times, .count = times.size()}; }

/// (k + jitter) / rate with a jitter of at most `size`.
VectorXd jittering(double rate, Index count, double size) {
  RandomStream random(1, "jitter");
  VectorXd times(count);
  for (Index k = 0; k < count; ++k) times[k] = (static_cast<double>(k) + size * (2.0 * random.uniform() - 1.0)) / rate;
  return times;
}

TEST(CommonGrid, OfRatesThatDivideEachOtherIsTheFastest) {
  const auto grid = common_grid({even(1000, 3001), even(500, 1501), even(1000.0 / 3.0, 1001)});
  EXPECT_EQ(grid.sample_rate, 1000.0);
  EXPECT_EQ(grid.last, 3000.0);
  EXPECT_LT(grid.largest_shift, 1e-9);
  EXPECT_EQ(places_on(grid, even(1000.0 / 3.0, 1001)).back(), 3000);
}

TEST(CommonGrid, IsFinerWhereSamplesLieBetween) {
  EXPECT_EQ(common_grid({even(1000, 1001), even(400, 401)}).sample_rate, 2000.0);
  EXPECT_EQ(common_grid({even(1000, 1001), even(1000, 1000, 0.0005)}).sample_rate, 2000.0);
  const auto odd = common_grid({even(1000, 5001), even(441, 2206)});
  EXPECT_LE(odd.sample_rate, 5000.0);
  EXPECT_LE(odd.largest_shift, 1.001e-4);
}

TEST(CommonGrid, StartsWithTheEarliestChannel) {
  const auto grid = common_grid({even(1000, 1001, 0.02), even(500, 501, 0.01)});
  EXPECT_DOUBLE_EQ(grid.start, 0.01);
  EXPECT_EQ(places_on(grid, even(1000, 1001, 0.02)).front(), 10);
}

TEST(CommonGrid, MovesNoSampleByMoreThanATenthOfAnInterval) {
  const VectorXd slight = jittering(1000, 2000, 0.08), strong = jittering(1000, 2000, 0.3);
  EXPECT_EQ(common_grid({uneven(slight)}).sample_rate, 1000.0);
  const auto grid = common_grid({uneven(strong)});
  EXPECT_GT(grid.sample_rate, 4000.0);
  const auto places = places_on(grid, uneven(strong));
  for (Index k = 0; k < strong.size(); ++k) {
    const double at = grid.start + static_cast<double>(places[static_cast<std::size_t>(k)]) / grid.sample_rate;
    EXPECT_LE(std::abs(at - strong[k]), 1.001e-4);
  }
}

TEST(CommonGrid, KeepsTheRateAcrossGaps) {
  VectorXd times(2000);
  for (Index k = 0; k < 2000; ++k) times[k] = 1e-3 * static_cast<double>(k < 700 ? k : k + 1234);
  const auto grid = common_grid({uneven(times)});
  EXPECT_DOUBLE_EQ(grid.sample_rate, 1000.0);
  EXPECT_EQ(grid.last, 1999.0 + 1234.0);
}

TEST(CommonGrid, RefusesSamplesThatNearlyCoincide) {
  VectorXd times = VectorXd::LinSpaced(100, 0.0, 0.99);
  times[50] = times[49] + 1e-6;
  EXPECT_THROW(common_grid({uneven(times)}), InvalidInput);
}

TEST(EvenlyInterpolated, FollowsASineBetweenUnevenSamples) {
  const VectorXd times = jittering(1000, 2000, 0.3), values = (2.0 * M_PI * 20.0 * times).array().sin();
  const VectorXd found = evenly_interpolated(uneven(times), values, 1000.0);
  for (Index k = 10; k + 10 < found.size(); ++k)
    EXPECT_NEAR(found[k], std::sin(2.0 * M_PI * 20.0 * (times[0] + 1e-3 * static_cast<double>(k))), 2e-5);
}

class SamplingTimes : public testing::Test {
protected:
  [[nodiscard]] std::filesystem::path file(const std::string& text) const {
    std::ofstream(folder_ / "record.csv", std::ios::binary) << text;
    return folder_ / "record.csv";
  }
  Record read(const std::string& text, const std::vector<std::string>& columns, bool missing = false) {
    notes_.clear();
    std::vector<WantedChannel> wanted;
    for (const auto& column : columns) wanted.push_back({.column = column, .owner = "sensors." + column, .unit = "m"});
    return read_record_file(file(text), wanted, {.missing = missing, .notes = &notes_});
  }
  std::string refusal(const std::string& text, const std::vector<std::string>& columns, bool missing = false) {
    try {
      read(text, columns, missing);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  }
  std::vector<std::string> notes_;

private:
  ScratchFolder folder_{"sampling_times"};
};

TEST_F(SamplingTimes, EveryColumnOfTimesServesTheChannelsBehindIt) {
  const auto record =
      read("t [s],a [mm],time [ms],b [m]\n0,1,0,10\n0.1,2,200,30\n0.2,3,400,50\n0.3,4,,\n0.4,5,,\n", {"a", "b"});
  EXPECT_DOUBLE_EQ(record.sample_rate, 10.0);
  EXPECT_EQ(record.samples(), 5);
  EXPECT_DOUBLE_EQ(record.values(0, 4), 5e-3);
  EXPECT_EQ(record.values(1, 2), 30.0);
  EXPECT_TRUE(std::isnan(record.values(1, 1)));
  ASSERT_EQ(notes_.size(), 1u);
  EXPECT_NE(notes_[0].find("'b' at 5 Hz"), std::string::npos) << notes_[0];
}

TEST_F(SamplingTimes, ThatJitterAreUsedAsTheyAre) {
  const auto record = read("t,a\n0,1\n0.13,2\n0.2,3\n0.27,4\n0.4,5\n0.5,6\n", {"a"});
  EXPECT_GT(record.sample_rate, 10.0);
  EXPECT_EQ(record.values.array().isFinite().count(), 6);
  for (Index k = 0; k < record.samples(); ++k)
    if (record.values(0, k) == 2.0) EXPECT_NEAR(record.time(k), 0.13, 0.0101);
  EXPECT_NE(notes_.at(0).find("uneven"), std::string::npos) << notes_[0];
}

TEST_F(SamplingTimes, OutOfOrderAreSorted) {
  const auto record = read("t,a\n0,1\n0.1,2\n0.3,4\n0.2,3\n0.4,5\n", {"a"});
  EXPECT_EQ(record.values, (Eigen::RowVectorXd(5) << 1, 2, 3, 4, 5).finished());
  EXPECT_DOUBLE_EQ(record.sample_rate, 10.0);
  ASSERT_EQ(notes_.size(), 1u);
  EXPECT_NE(notes_[0].find("first at line 5"), std::string::npos) << notes_[0];
}

TEST_F(SamplingTimes, ThatOccurTwiceOrStartAgainAreRefused) {
  EXPECT_NE(refusal("t,a\n0,1\n0.1,2\n0.1,3\n0.2,4\n0.3,5\n", {"a"}).find(":4: "), std::string::npos);
  EXPECT_NE(refusal("t,a\n0,1\n0.1,2\n0.2,3\n0.3,4\n0.05,1\n0.15,2\n0.25,3\n", {"a"}).find("time must increase"),
            std::string::npos);
}

TEST_F(SamplingTimes, WithGapsNeedLeaveToMissSamples) {
  const std::string gap = "t,a\n0,1\n0.1,2\n0.2,3\n0.5,6\n0.6,7\n0.7,8\n";
  const std::string refused = refusal(gap, {"a"});
  EXPECT_NE(refused.find("2 samples are missing"), std::string::npos) << refused;
  EXPECT_NE(refused.find("skip_missing"), std::string::npos) << refused;
  const auto record = read(gap, {"a"}, true);
  EXPECT_DOUBLE_EQ(record.sample_rate, 10.0);
  EXPECT_EQ(record.samples(), 8);
  EXPECT_TRUE(std::isnan(record.values(0, 3)));
  EXPECT_EQ(record.values(0, 7), 8.0);
}

}  // namespace
}  // namespace kalfem
