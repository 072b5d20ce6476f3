// SPDX-License-Identifier: Apache-2.0
#include "kalfem/watch/stream_line.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/watch/stream_source.hpp"

namespace kalfem {
namespace {

using testing::HasSubstr;

std::string refusal(StreamLines& lines, const std::string& line) try {
  lines.read(line);
  return "";
} catch (const InvalidInput& error) {
  return error.what();
}

TEST(StreamLines, ReadSamplesAndBlocks) {
  StreamLines lines;
  const auto one = lines.read(R"({"t": 1.5, "a3": 0.25, "road": null})");
  ASSERT_EQ(one.size(), 2U);
  EXPECT_EQ(one[0].column, "a3");
  EXPECT_EQ(one[0].time, 1.5);
  EXPECT_EQ(one[0].values, (std::vector{0.25}));
  EXPECT_TRUE(std::isnan(one[1].values.at(0)));
  const auto several = lines.read(R"({"a3": [1, null, -3e-2], "dt": 0.01, "t": -2})");
  ASSERT_EQ(several.size(), 1U);
  EXPECT_EQ(several[0].interval, 0.01);
  EXPECT_EQ(several[0].time, -2.0);
  EXPECT_EQ(several[0].values[2], -0.03);
  EXPECT_TRUE(std::isnan(several[0].values[1]));
}

TEST(StreamLines, ReadRowsBehindTheirNames) {
  StreamLines lines;
  EXPECT_THAT(refusal(lines, "1.5,2"), HasSubstr("before the names of its columns"));
  EXPECT_TRUE(lines.read("t [s], a3 [g] ,road (mm)\r\n").empty());
  const auto row = lines.read(" 1.5 , 2 ,\r\n");
  ASSERT_EQ(row.size(), 2U);
  EXPECT_EQ(row[0].column, "a3");
  EXPECT_EQ(row[0].unit, "g");
  EXPECT_EQ(row[1].unit, "mm");
  EXPECT_EQ(row[0].values, (std::vector{2.0}));
  EXPECT_TRUE(std::isnan(row[1].values[0]));
  EXPECT_THAT(refusal(lines, "1.5,2"), HasSubstr("2 places: there are 3 columns"));
  EXPECT_THAT(refusal(lines, "1.5,2,x"), HasSubstr("'x' in the column 'road'"));
  EXPECT_TRUE(lines.read("").empty());
}

TEST(StreamLines, RefuseWhatTheyCannotPlace) {
  StreamLines lines;
  EXPECT_THAT(refusal(lines, "{\"t\": 1"), HasSubstr("no JSON object"));
  EXPECT_THAT(refusal(lines, "{\"a3\": 1}"), HasSubstr("has no time"));
  EXPECT_THAT(refusal(lines, "{\"t\": 1, \"a3\": \"x\"}"), HasSubstr("holds something that is no number"));
  EXPECT_THAT(refusal(lines, "{\"t\": 1, \"dt\": 0, \"a3\": 1}"), HasSubstr("\"dt\" is no time"));
  EXPECT_THAT(refusal(lines, "hello"), HasSubstr("neither JSON nor CSV"));
  EXPECT_THAT(refusal(lines, std::string(2'000'000, '1')), HasSubstr("2000000 bytes"));
}

TEST(StreamLines, SurviveRandomBytes) {
  std::mt19937 random(1);
  const std::string letters = "{}[]\":,.0123456789eE+-tdNa \\u\xff\x01";
  StreamLines lines;
  for (int i = 0; i < 20000; ++i) {
    std::string line = i % 2 ? R"({"t": 1.5, "a3": [0.25, 1]})" : "1.5,2,3";
    for (int k = 0; k < 4; ++k) line[random() % line.size()] = letters[random() % letters.size()];
    try {
      for (const auto& block : lines.read(line)) EXPECT_TRUE(std::isfinite(block.time));
    } catch (const InvalidInput&) {
    }
  }
}

TEST(LineCutter, CutsPiecesIntoLines) {
  LineCutter cutter;
  std::vector<std::string> lines;
  const auto keep = [&](std::string_view line) { lines.emplace_back(line); };
  for (const char* piece : {"a", "b\nc", "\n\n", "a line that is too long", " by far\nd"}) cutter.add(piece, 10, keep);
  EXPECT_EQ(lines, (std::vector<std::string>{"ab", "c", "", "a line that"}));
  EXPECT_EQ(cutter.take_rest(), "d");
  EXPECT_EQ(cutter.take_rest(), "");
}

TEST(StreamLines, TakesTheUnitOfALine) {
  StreamLines lines;
  const auto blocks = lines.read(R"({"t": 1, "unit": "g", "a3": 0.5, "a4": [1, 2]})");
  ASSERT_EQ(blocks.size(), 2U);
  EXPECT_EQ(blocks[0].unit, "g");
  EXPECT_EQ(blocks[1].unit, "g");
  EXPECT_THROW(lines.read(R"({"t": 1, "unit": 3, "a3": 0.5})"), InvalidInput);
}

}  // namespace
}  // namespace kalfem
