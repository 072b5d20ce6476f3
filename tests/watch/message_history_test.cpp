// SPDX-License-Identifier: Apache-2.0
#include "kalfem/watch/message_history.hpp"

#include <gtest/gtest.h>

namespace kalfem {
namespace {

TEST(MessageHistory, TellsWhatHasNotBeenSeen) {
  MessageHistory history;
  std::int64_t seen = 0;
  EXPECT_EQ(history.events_after(seen, 1000), "");
  history.add(MessageKind::estimates, "tower", R"({"t":1})");
  history.add(MessageKind::alarm, "a \"b\"\n", R"({"alarm":{}})");
  EXPECT_EQ(history.events_after(seen, 1000),
            "data: {\"case\":\"tower\",\"kind\":\"estimates\",\"line\":{\"t\":1}}\n\n"
            "data: {\"case\":\"a \\\"b\\\"\\n\",\"kind\":\"alarm\",\"line\":{\"alarm\":{}}}\n\n");
  EXPECT_EQ(history.events_after(seen, 1000), "");
  history.add(MessageKind::trend, "tower", R"({"trend":{}})");
  EXPECT_EQ(history.events_after(seen, 1000),
            "data: {\"case\":\"tower\",\"kind\":\"trend\",\"line\":{\"trend\":{}}}\n\n");
}

TEST(MessageHistory, GivesPiecesOfAboutTheSizeAskedForAndNoMessageTwice) {
  MessageHistory history;
  for (int i = 0; i < 10; ++i) history.add(MessageKind::estimates, "a", std::to_string(i));
  std::int64_t seen = 0;
  std::string all, one;
  std::size_t pieces = 0;
  while (!(one = history.events_after(seen, 1)).empty()) {
    all += one;
    ++pieces;
  }
  EXPECT_EQ(pieces, 10U);
  seen = 0;
  EXPECT_EQ(history.events_after(seen, 100'000), all);
}

TEST(MessageHistory, DropsTheOldestAndSaysNothingOfThem) {
  MessageHistory history(200);
  for (int i = 0; i < 1000; ++i) history.add(MessageKind::estimates, "a", std::to_string(i));
  std::int64_t seen = 3;
  const auto text = history.events_after(seen, 100'000);
  EXPECT_LE(text.size(), 200U);
  EXPECT_NE(text.find("\"line\":999}"), std::string::npos);
  EXPECT_EQ(text.find("\"line\":3}"), std::string::npos);
  EXPECT_EQ(seen, 1000);
  history.add(MessageKind::estimates, "a", std::string(500, ' ') + "0");
  EXPECT_GT(history.events_after(seen, 1).size(), 500U);  // one that is too long alone is told all the same
}

}  // namespace
}  // namespace kalfem
