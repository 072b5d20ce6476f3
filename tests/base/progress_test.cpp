// SPDX-License-Identifier: Apache-2.0
#include "kalfem/base/progress.hpp"

#include <gtest/gtest.h>

namespace kalfem {
namespace {

using Calls = std::vector<std::pair<std::string, double>>;

struct Shown {
  Calls calls;
  Progress progress = [this](std::string_view words, double fraction) { calls.emplace_back(words, fraction); };

  void expect(const Calls& expected) const {
    ASSERT_EQ(calls.size(), expected.size());
    for (std::size_t i = 0; i < calls.size(); ++i) {
      EXPECT_EQ(calls[i].first, expected[i].first);
      EXPECT_DOUBLE_EQ(calls[i].second, expected[i].second) << calls[i].first;
    }
  }
};

TEST(JobProgress, ShowsTheStepsPlaceAndTheFractionOfTheWhole) {
  Shown shown;
  JobProgress job({{"simulate", 3.0}, {"estimate", 1.0}}, shown.progress);
  const Progress simulate = job.begin("simulate");
  simulate("reference 2 of 3", 0.5);
  const Progress estimate = job.begin("estimate");
  estimate("estimate", 0.5);
  shown.expect({{"simulate (1 of 2)", 0.0},
                {"simulate (1 of 2): reference 2 of 3", 0.375},
                {"estimate (2 of 2)", 0.75},
                {"estimate (2 of 2)", 0.875}});
}

TEST(JobProgress, NeverFallsAndStaysInItsStep) {
  Shown shown;
  JobProgress job({{"a", 1.0}, {"b", 1.0}}, shown.progress);
  const Progress a = job.begin("a");
  a("x", 0.8);
  a("y", 0.1);
  a("z", 7.0);
  shown.expect({{"a (1 of 2)", 0.0}, {"a (1 of 2): x", 0.4}, {"a (1 of 2): y", 0.4}, {"a (1 of 2): z", 0.5}});
}

TEST(JobProgress, OfAStepThatIsNotPlannedIsEmpty) {
  Shown shown;
  JobProgress job({{"a"}}, shown.progress);
  EXPECT_FALSE(job.begin("b"));
  EXPECT_TRUE(shown.calls.empty());
  EXPECT_FALSE(JobProgress({{"a"}}, {}).begin("a"));
}

TEST(Passes, EachTakeHalfOfWhatIsLeft) {
  Shown shown;
  const Progress passes = passes_of(shown.progress, "pass");
  for (const double fraction : {0.0, 0.5, 1.0, 0.0, 0.5, 0.25}) passes("estimate", fraction);
  shown.expect(
      {{"pass 1", 0.0}, {"pass 1", 0.25}, {"pass 1", 0.5}, {"pass 2", 0.5}, {"pass 2", 0.625}, {"pass 3", 0.78125}});
  EXPECT_FALSE(passes_of({}, "pass"));
}

TEST(PartOf, GoesFromOneFractionToTheOther) {
  Shown shown;
  part_of(shown.progress, 0.2, 0.6)("x", 0.5);
  shown.expect({{"x", 0.4}});
  EXPECT_FALSE(part_of({}, 0.0, 1.0));
}

}  // namespace
}  // namespace kalfem
