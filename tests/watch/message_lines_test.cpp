// SPDX-License-Identifier: Apache-2.0
#include "kalfem/watch/message_lines.hpp"

#include <gmock/gmock.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

using Json = nlohmann::json;

TEST(MessageLines, ReadsBinaryBlocksAndJsonAlike) {
  MessageLines lines;
  const auto binary = Json::parse(
      *lines.line_of("tower/a3", binary_block(7, 1.25, 0.01, {0.5, std::numeric_limits<double>::quiet_NaN(), -2.0})));
  const auto text =
      Json::parse(*lines.line_of("other/a3", R"({"t0": 1.25, "dt": 0.01, "counter": 7, "values": [0.5, null, -2.0]})"));
  EXPECT_EQ(binary, Json::parse(R"({"t": 1.25, "dt": 0.01, "a3": [0.5, null, -2.0]})"));
  EXPECT_EQ(text, binary);
  EXPECT_EQ(Json::parse(*lines.line_of("tower/all", R"({"t": 2, "a3": 1, "T": 20})")),
            Json::parse(R"({"t": 2, "a3": 1, "T": 20})"));
  EXPECT_EQ(Json::parse(*lines.line_of("tower/a4", R"({"t0": 2, "unit": "g", "values": [1]})")),
            Json::parse(R"({"t": 2, "unit": "g", "a4": [1]})"));
}

TEST(MessageLines, DropsWhatComesAgainAndCountsWhatIsLost) {
  MessageLines lines;
  const auto taken = [&](std::uint32_t counter) {
    return lines.line_of("a", binary_block(counter, 0.0, 0.01, {1.0})).has_value();
  };
  EXPECT_TRUE(taken(4294967295U));
  EXPECT_TRUE(taken(0));  // it runs over
  EXPECT_FALSE(taken(0));
  EXPECT_TRUE(taken(3));
  EXPECT_FALSE(taken(1));
  EXPECT_EQ(lines.repeated(), 2);
  EXPECT_EQ(lines.lost(), 2);
  EXPECT_TRUE(taken(1'000'000));  // begun anew
  EXPECT_EQ(lines.lost(), 2);
}

TEST(MessageLines, RefusesWhatHoldsNoSamples) {
  MessageLines lines;
  for (const std::string& payload : {std::string("nonsense"), std::string("[1]"), std::string("KFB1"),
                                     binary_block(1, 0.0, 0.01, {1.0}) + "x", std::string(R"({"counter": -1})")})
    EXPECT_THROW(lines.line_of("a", payload), InvalidInput) << payload;
}

}  // namespace
}  // namespace kalfem
