// SPDX-License-Identifier: Apache-2.0
#include "kalfem/base/invalid_input.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace kalfem {
namespace {

std::vector<Issue> issues(int count) {
  std::vector<Issue> all;
  for (int i = 1; i <= count; ++i) all.push_back({{"case.yaml", i}, "problem " + std::to_string(i), "", ""});
  return all;
}

TEST(InvalidInput, TellsAFewProblemsInFull) {
  const std::string text = InvalidInput(issues(15)).what();
  EXPECT_EQ(std::ranges::count(text, '\n'), 14);
  EXPECT_NE(text.find("case.yaml:15: problem 15"), std::string::npos);
  EXPECT_EQ(text.find("more"), std::string::npos);
}

TEST(InvalidInput, CountsTheOthersAtTheEnd) {
  const InvalidInput error(issues(150'000));
  const std::string text = error.what();
  EXPECT_EQ(std::ranges::count(text, '\n'), 15);
  EXPECT_TRUE(text.ends_with("\nand 149985 more problems; correct these first")) << text;
  EXPECT_EQ(error.issues().size(), 150'000U);
}

TEST(InvalidInput, KeepsEachProblemToOneLineOfBoundedLength) {
  const std::string long_name = "first\nsecond" + std::string(10'000, 'x');
  const std::string text = to_string(Issue{{"case.yaml", 3}, long_name, long_name, long_name});
  EXPECT_LT(text.size(), 1'500U);
  EXPECT_TRUE(text.starts_with("case.yaml:3: first\\nsecond")) << text;
  const std::string umlauts = InvalidInput("a" + std::string(300, '\xC3') + "b", "", "").what();
  EXPECT_LT(umlauts.size(), 500U);
  std::string pairs;
  for (int i = 0; i < 300; ++i) pairs += "\xC3\xA4";
  const std::string cut = to_string(Issue{{}, "a" + pairs, "", ""});
  EXPECT_EQ(static_cast<unsigned char>(cut[cut.find(" ...") - 1]), 0xA4U);
}

TEST(DidYouMean, NamesTheNearestButNeverWhatWasWritten) {
  EXPECT_EQ(did_you_mean("bodi.1", {"wheel.w", "body.1"}), " (did you mean 'body.1'?)");
  EXPECT_EQ(did_you_mean("body.1", {"body.2", "body.1"}), "");
  EXPECT_EQ(did_you_mean("zebra", {"body.1", "wheel.w"}), "");
  EXPECT_EQ(did_you_mean(std::string(1'000'000, 'x'), {std::string(999'999, 'x')}), "");
}

}  // namespace
}  // namespace kalfem
