// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/record.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "kalfem/base/invalid_input.hpp"

// One record type, channels x samples: its channels by name, its parts by time, its missing samples.
namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double missing = std::numeric_limits<double>::quiet_NaN();

/// Channel c at sample k is 10 c + k; from 2 s on, 4 Hz.
Record counting() {
  Record record{4.0, 2.0, {{"a", "m", 0.1}, {"b", "m/s", 0.2}, {"c", "N", 0.3}}, MatrixXd(3, 8)};
  for (Index c = 0; c < 3; ++c)
    for (Index k = 0; k < 8; ++k) record.values(c, k) = double(10 * c + k);
  return record;
}

std::string refusal(const std::function<void()>& action) {
  try {
    action();
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

TEST(Record, HasItsSamplesInColumnsAndItsChannelsInRows) {
  const Record record = counting();
  EXPECT_EQ(record.samples(), 8);
  EXPECT_EQ(record.time(3), 2.75);
  EXPECT_EQ(record.end(), 3.75);
  EXPECT_EQ(record.find("b"), 1);
  EXPECT_EQ(record.find("B"), -1);
  EXPECT_EQ(record.noise(), VectorXd(Eigen::Vector3d(0.1, 0.2, 0.3)));
  // a sample is contiguous
  EXPECT_EQ(&record.values(1, 5) - &record.values(0, 5), 1);
}

TEST(Record, SelectsChannelsInTheOrderOfTheNamesWithAllThatIsKnownOfThem) {
  Record record = counting();
  record.values(0, 5) = missing;
  record.used = 6;
  const Record selected = select_channels(record, {"c", "a"});
  EXPECT_EQ(selected.values.rows(), 2);
  EXPECT_EQ(selected.values.row(0), record.values.row(2));
  EXPECT_EQ(selected.values(1, 4), 4.0);
  EXPECT_TRUE(std::isnan(selected.values(1, 5)));
  EXPECT_EQ(selected.channels[0].name, "c");
  EXPECT_EQ(selected.channels[0].unit, "N");
  EXPECT_EQ(selected.noise(), VectorXd(Eigen::Vector2d(0.3, 0.1)));
  EXPECT_EQ(selected.start, 2.0);
  EXPECT_EQ(selected.sample_rate, 4.0);
  EXPECT_EQ(selected.samples_used(), 6);
}

TEST(Record, NamesEveryChannelThatItDoesNotHave) {
  const Record record = counting();
  const std::string text = refusal([&] { select_channels(record, {"a", "x", "y"}); });
  EXPECT_NE(text.find("'x'"), std::string::npos) << text;
  EXPECT_NE(text.find("'y'"), std::string::npos) << text;
}

TEST(Record, IsCutAtTimesOfItsClock) {
  Record record = counting();
  EXPECT_EQ(record.samples_used(), 8);
  const Record part = cut(record, 2.3, 3.5);
  EXPECT_EQ(part.start, 2.5);
  EXPECT_EQ(part.samples(), 5);
  EXPECT_EQ(part.values, MatrixXd(record.values.middleCols(2, 5)));
  EXPECT_EQ(cut(record, -1.0, 9.0).values, record.values);
  // a filter learns from the samples of the part that it learnt from in the whole
  record.used = 4;
  EXPECT_EQ(cut(record, 2.5, 3.75).samples_used(), 2);
  EXPECT_EQ(cut(record, 3.25, 3.75).samples_used(), 0);
  const std::string text = refusal([&] { cut(record, 5.0, 6.0); });
  EXPECT_NE(text.find("2 s to 3.75 s"), std::string::npos) << text;
}

TEST(Record, IsMadeOfSeriesOfOneLength) {
  const VectorXd a = VectorXd::LinSpaced(4, 0.0, 3.0);
  const Record record = make_record(100.0, {{"a", a}, {"b", 2.0 * a}}, 0.5);
  EXPECT_EQ(record.sample_rate, 100.0);
  EXPECT_EQ(record.start, 0.5);
  EXPECT_EQ(record.values.row(1).transpose(), 2.0 * a);
  EXPECT_EQ(record.channels[1].name, "b");
  const std::string text = refusal([&] { make_record(100.0, {{"a", a}, {"b", a.head(3)}}); });
  EXPECT_NE(text.find("channel 'b' has 3 samples"), std::string::npos) << text;
}

TEST(Record, RmsLeavesOutMissingSamples) {
  EXPECT_DOUBLE_EQ(rms_of_present(Eigen::Vector4d(3.0, missing, -4.0, missing)), std::sqrt(12.5));
  EXPECT_EQ(rms_of_present(Eigen::Vector2d(missing, missing)), 0.0);
}

}  // namespace
}  // namespace kalfem
