// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/finished/sweep.hpp"

#include <gtest/gtest.h>

#include "base/scratch_folder.hpp"
#include "cli/short_case.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/report/finished/sweep_report.hpp"
#include "kalfem/steps/simulation/checkpoint.hpp"
#include "kalfem/study/study.hpp"

// Runs by their numbers, as somebody who shares them out asks for them.

namespace kalfem::test {
namespace {

class SweepByNumbers : public testing::Test {
protected:
  [[nodiscard]] SweepPlan plan() const {
    return {.case_file = file_, .axes = {{"simulate.duration", {"0.5s", "-1s", "0.6s"}}}, .seeds = 2};
  }

  ScratchFolder folder_{"sweep-by-numbers"};
  std::string file_ = write_case(folder_, "case.yaml", short_case("swept"));
};

std::vector<std::string> lines_of(const std::vector<SweepRun>& runs) {
  std::vector<std::string> lines;
  for (const auto& run : runs) lines.push_back(to_line(run));
  return lines;
}

TEST_F(SweepByNumbers, AnyOrderGivesTheSameRuns) {
  CaseSweep whole(plan()), by_numbers(plan());
  const auto expected = lines_of(whole.run({.threads = 2}));
  EXPECT_EQ(whole.identity(), by_numbers.identity());
  ASSERT_EQ(expected.size(), 6U);
  for (const std::size_t number : {5U, 0U, 4U, 2U, 1U, 3U, 0U})
    EXPECT_EQ(to_line(by_numbers.run_one(number)), expected[number]) << number;
}

TEST_F(SweepByNumbers, ACombinationThatCannotBeRunSaysWhyInEachRun) {
  CaseSweep sweep(plan());
  for (const std::size_t number : {2U, 3U}) {
    const SweepRun run = sweep.run_one(number);
    EXPECT_NE(run.refused.find("simulate.duration"), std::string::npos) << run.refused;
    EXPECT_TRUE(run.summary.empty());
  }
  EXPECT_TRUE(sweep.run_one(4).refused.empty());
}

TEST_F(SweepByNumbers, KnownRunsAreNotMadeAgain) {
  CaseSweep sweep(plan());
  SweepRun known = sweep.run_one(1);
  known.summary = "{}";
  std::vector<std::size_t> made;
  const auto runs =
      sweep.run({.threads = 1, .known = {known}, .on_run = [&](const SweepRun& run) { made.push_back(run.number); }});
  EXPECT_EQ(made, (std::vector<std::size_t>{0, 2, 3, 4, 5}));
  EXPECT_EQ(runs[1].summary, "{}");
}

TEST_F(SweepByNumbers, ARunThatIsNotThereIsRefused) {
  CaseSweep sweep(plan());
  EXPECT_THROW(
      {
        try {
          (void)sweep.run_one(6);
        } catch (const InvalidInput& error) {
          EXPECT_STREQ(error.what(), "run 6 is asked for: the sweep has fewer; numbers are 0 to 5");
          throw;
        }
      },
      InvalidInput);
}

TEST_F(SweepByNumbers, WhatChangesARunChangesTheIdentity) {
  const std::string identity = CaseSweep(plan()).identity();
  auto other = plan();
  other.changes = {{"estimate.settle", "0.2s"}};
  EXPECT_NE(CaseSweep(other).identity(), identity);
  other = plan();
  other.seeds = 3;
  EXPECT_NE(CaseSweep(other).identity(), identity);
}

TEST_F(SweepByNumbers, AReferenceIsSharedWhereEstimateAloneDiffers) {
  const auto with = [&](const std::string& key, const std::string& value) {
    return simulation_fingerprint(load_study(file_, {{key, value}}));
  };
  const std::string as_given = simulation_fingerprint(load_study(file_));
  EXPECT_EQ(with("estimate.settle", "0.2s"), as_given);
  EXPECT_EQ(with("estimate.filter", "ukf"), as_given);
  EXPECT_EQ(with("estimate.unknown.suspension.k.initial", "5 kN/m"), as_given);
  for (const auto& [key, value] : {std::pair{"simulate.duration", "0.6s"},
                                   {"simulate.seed", "2"},
                                   {"sensors.a.noise", "10 %"},
                                   {"connectors.suspension.parameters.k", "6 kN/m"},
                                   {"excitation.road.random.seed", "5"},
                                   {"report.displacements", "[body.1]"}})
    EXPECT_NE(with(key, value), as_given) << key;
}

TEST(LinesOfSweepRuns, GiveTheRunBack) {
  const SweepRun done{7, {"0.1", "a \"b\""}, 3, R"({"status":"ok","nis":3.0000000000000004})", ""};
  const SweepRun refused{8, {}, std::nullopt, "", "line 1\nµ"};
  for (const auto& run : {done, refused}) {
    const std::string line = to_line(run);
    EXPECT_EQ(line.find('\n'), std::string::npos);
    const auto found = sweep_run_of(line);
    ASSERT_TRUE(found) << line;
    EXPECT_EQ(found->number, run.number);
    EXPECT_EQ(found->values, run.values);
    EXPECT_EQ(found->seed, run.seed);
    EXPECT_EQ(found->summary, run.summary);
    EXPECT_EQ(found->refused, run.refused);
    for (const std::size_t length : {std::size_t{0}, line.size() / 2, line.size() - 1})
      EXPECT_FALSE(sweep_run_of(line.substr(0, length))) << length;
  }
  EXPECT_FALSE(sweep_run_of(R"({"run": "seven", "values": [], "seed": null})"));
  EXPECT_FALSE(sweep_run_of("[]"));
}

}  // namespace
}  // namespace kalfem::test
