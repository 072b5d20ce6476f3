// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "casefile/case_run.hpp"
#include "casefile/small_cases.hpp"
#include "kalfem/base/interruption.hpp"
#include "kalfem/identification/stated_interval.hpp"
#include "kalfem/report/console_report.hpp"
#include "kalfem/report/result_set.hpp"
#include "kalfem/steps/estimation/report.hpp"
#include "kalfem/steps/run_study.hpp"

// The first answer of an estimation, and what may follow it.

namespace kalfem::test {
namespace {

/// Four substeps of second order bias its estimate by several deviations; sixteen do not.
std::string oscillator_with(const std::string& settings) {
  return cubic_oscillator +
         "estimate:\n  unknown: {c.k3: {initial: 1e7, std: 50 %}}\n  settle: 0.2 s\n  step_order: 2\n" + settings;
}

StudyResults run_with(const std::string& settings, std::vector<StudyResults>* first = nullptr) {
  RunOptions options;
  if (first) options.on_first_answer = [&](const StudyResults& results) { first->push_back(results); };
  return run_study(study_of(oscillator_with(settings)), "estimate", options);
}

double half_width(const RecordEstimate& estimate) {
  const auto interval = stated_interval(estimate, 0);
  return 0.5 * (interval.upper - interval.lower);
}

TEST(SecondThoughts, FollowTheFirstAnswer) {
  std::vector<StudyResults> first;
  const auto results = run_with("  second_thoughts: full\n", &first);
  ASSERT_EQ(first.size(), 1U);
  const auto& answer = first.front().get<EstimationOutcome>();
  EXPECT_EQ(answer.second_thoughts, SecondThoughts::pending);
  EXPECT_EQ(answer.substeps.substeps, 4);
  EXPECT_TRUE(answer.substeps.limited);
  EXPECT_GT(answer.substeps.bias[0], 0.2);
  EXPECT_TRUE(answer.process_noise.empty());
  EXPECT_EQ(results.get<EstimationOutcome>().second_thoughts, SecondThoughts::done);
  EXPECT_EQ(results.get<EstimationOutcome>().substeps.substeps, 16);
  EXPECT_TRUE(results.get<EstimationOutcome>().left_out.empty());
  EXPECT_LE(results.get<EstimationOutcome>().first_answer_seconds, results.get<EstimationOutcome>().seconds);
}

TEST(SecondThoughts, HoldTheBiasOfTheSubstepsInTheInterval) {
  const auto results = run_with("  second_thoughts: none\n");
  const auto& estimate = results.get<EstimationOutcome>();
  EXPECT_EQ(estimate.second_thoughts, SecondThoughts::none);
  EXPECT_EQ(estimate.substeps.substeps, 4);
  RecordEstimate settled = estimate;
  settled.substeps.limited = false;
  const double deviation = estimate.result.unknowns.deviation(0, estimate.result.unknowns.deviation.cols() - 1);
  const double robust = std::max(1.0, estimate.robust_deviation[0] / deviation), bias = estimate.substeps.bias[0];
  EXPECT_NEAR(half_width(estimate) / half_width(settled), std::hypot(robust, bias) / robust, 1e-12);
  EXPECT_LT(std::abs(estimate.result.unknowns.mean.rightCols(1)(0) - 2e7), half_width(estimate));
}

TEST(SecondThoughts, TakeNoMoreFilterStepsThanTheyMay) {
  std::vector<StudyResults> none;
  const auto without = run_with("  second_thoughts: none\n", &none);
  EXPECT_TRUE(none.empty());  // nothing follows, so it is the only answer
  // The first answer takes passes with 4 and 2 substeps; the run with eight is the estimate's where no more are
  // allowed.
  EXPECT_EQ(run_with("  second_thoughts: 1.3\n").get<EstimationOutcome>().left_out.front(), "more substeps");
  const auto tried = run_with("  second_thoughts: 1.4\n");
  EXPECT_EQ(tried.get<EstimationOutcome>().substeps.substeps, 8);
  EXPECT_LT(tried.get<EstimationOutcome>().substeps.bias[0], 4.0 * without.get<EstimationOutcome>().substeps.bias[0]);
  EXPECT_EQ(tried.get<EstimationOutcome>().second_thoughts, SecondThoughts::stopped);
  const auto full = run_with("  second_thoughts: full\n"), enough = run_with("  second_thoughts: 100\n");
  EXPECT_EQ(enough.get<EstimationOutcome>().second_thoughts, SecondThoughts::done);
  EXPECT_EQ(enough.get<EstimationOutcome>().result.unknowns.mean,
            full.get<EstimationOutcome>().result.unknowns.mean);  // bit by bit
}

TEST(SecondThoughts, AreTold) {
  const Study study = study_of(oscillator_with("  second_thoughts: 1\n"));
  const auto results = run_study(study, "estimate");
  const auto summary = summarise(study, results);
  EXPECT_EQ(summary["second_thoughts"], "stopped");
  EXPECT_EQ(summary["estimation"]["left_out"][0], "more substeps");
  const auto told = std::ranges::find_if(results.warnings, [](const std::string& warning) {
    return warning.find("second_thoughts: 1 allow") != std::string::npos;
  });
  EXPECT_NE(told, results.warnings.end());
  EXPECT_NE(console_report(study, results).find("more substeps are needed than second_thoughts allow"),
            std::string::npos);
  EXPECT_NE(console_first_answer(study, results.get<EstimationOutcome>()).find("second thoughts follow"),
            std::string::npos);
}

TEST(SecondThoughts, AreANumberOrAWord) {
  for (const std::string wrong : {"-1", "some", "nan"})
    EXPECT_NE(problems_of(oscillator_with("  second_thoughts: " + wrong + "\n")).find("second_thoughts"),
              std::string::npos)
        << wrong;
}

TEST(SecondThoughts, KeepTheFirstAnswerWhereTheRunIsStopped) {
  bool answered = false;
  RunOptions options{.on_first_answer = [&](const StudyResults&) { answered = true; }, .keep_finished = true};
  const Study study = study_of(oscillator_with(""));
  const StopQuestion question = [&] { return answered; };
  const StopScope scope(&question);
  const auto results = run_study(study, "estimate", options);
  EXPECT_TRUE(results.interrupted);
  ASSERT_TRUE(results.has<EstimationOutcome>());
  EXPECT_EQ(results.get<EstimationOutcome>().second_thoughts, SecondThoughts::stopped);
  EXPECT_EQ(results.get<EstimationOutcome>().substeps.substeps, 4);
}

}  // namespace
}  // namespace kalfem::test
