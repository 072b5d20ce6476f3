// SPDX-License-Identifier: Apache-2.0
#include "kalfem/watch/playback.hpp"

#include "kalfem/base/invalid_input.hpp"
#include "live_case.hpp"

namespace kalfem {
namespace {

using testing::HasSubstr;

Playback ten_seconds() {
  return {.sample_rate = 10.0, .start = 5.0, .channels = {{"a", Eigen::VectorXd::LinSpaced(101, 0.0, 100.0)}}};
}

std::string refusal(const std::string& text) try {
  Playback playback = ten_seconds();
  apply_faults({scheduled_fault(text)}, playback);
  return "";
} catch (const InvalidInput& error) {
  return error.what();
}

TEST(Playback, AppliesFaultsBySchedule) {
  Playback playback = ten_seconds();
  apply_faults({scheduled_fault("dead:a:1:2"), scheduled_fault("offset:a:3:4:0.5"), scheduled_fault("spike:a:5::30"),
                scheduled_fault("spike:a:6:8:7"), scheduled_fault("gap:a:9")},
               playback);
  const auto& values = playback.channels[0].values;
  EXPECT_EQ(values[9], 9.0);
  EXPECT_EQ(values[10], 0.0);
  EXPECT_EQ(values[20], 0.0);
  EXPECT_EQ(values[21], 21.0);
  EXPECT_EQ(values[35], 35.5);
  EXPECT_EQ(values[50], 80.0);
  EXPECT_EQ(values[51], 51.0);
  for (const Eigen::Index k : {60, 70, 80}) EXPECT_EQ(values[k], double(k) + 7.0);
  EXPECT_EQ(values[65], 65.0);
  EXPECT_EQ(values[89], 89.0);
  EXPECT_TRUE(values.tail(11).array().isNaN().all());
}

TEST(Playback, WritesLinesWithTimes) {
  Playback playback = ten_seconds();
  playback.channels.push_back({"b", Eigen::VectorXd::Constant(101, std::nan("")), 0.2});
  const auto lines = playback.lines(10, 2);
  ASSERT_EQ(lines.size(), 2U);  // one for each delay
  EXPECT_EQ(lines[0], R"({"t":6.0,"dt":0.1,"a":[10.0,11.0]})");
  EXPECT_EQ(lines[1], R"({"t":6.2,"dt":0.1,"b":[null,null]})");
}

TEST(Playback, RefusesFaultsThatItCannotRead) {
  EXPECT_THAT(refusal("dies:a:1"), HasSubstr("kinds are dead, spike, offset and gap"));
  EXPECT_THAT(refusal("dead:a"), HasSubstr("no fault is written like that"));
  EXPECT_THAT(refusal("dead:a:x"), HasSubstr("'x' is no number"));
  EXPECT_THAT(refusal("dead:a:3:2"), HasSubstr("ends before it begins"));
  EXPECT_THAT(refusal("offset:a:3:4"), HasSubstr("the value is missing"));
  EXPECT_THAT(refusal("dead:b:1"), HasSubstr("no channel 'b'"));
  EXPECT_EQ(refusal("dead:a:1:2:3"), "");
}

}  // namespace
}  // namespace kalfem
