// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "casefile/case_run.hpp"
#include "casefile/small_cases.hpp"
#include "kalfem/report/console_report.hpp"
#include "kalfem/report/result_set.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/judge.hpp"

// How finely a case's filter divides a sample interval, what it assumes of the first sample, and what is said of both.

namespace kalfem::test {
namespace {

const std::string oscillator = cubic_oscillator + R"(estimate:
  unknown: {c.k3: {initial: 1e7, std: 50 %}}
  settle: 0.2 s
  second_thoughts: full
)";

std::string of_second_order() { return changed(oscillator, "settle: 0.2 s", "settle: 0.2 s\n  step_order: 2"); }

TEST(SubstepsOfACase, AreChosenAndReported) {
  const Study study = study_of(of_second_order());
  const auto results = run_study(study, "estimate");
  ASSERT_TRUE(results.complete()) << results.failure;
  const auto summary = summarise(study, results)["estimation"];
  EXPECT_EQ(summary["substeps"], 16);
  EXPECT_EQ(summary["substeps_chosen"], true);
  EXPECT_LE(summary["substep_bias"]["c.k3"].get<double>(), 0.2);
  EXPECT_EQ(summary["start"]["moving"], false);
  const std::string text = console_report(study, results);
  EXPECT_NE(text.find("16 substeps per sample, chosen"), std::string::npos) << text;
  EXPECT_NE(text.find("'c.k3'"), std::string::npos) << text;
}

TEST(SubstepsOfACase, AreFewByDefault) {
  const Study study = study_of(oscillator);
  const auto results = run_study(study, "estimate");
  const auto summary = summarise(study, results)["estimation"];
  EXPECT_LE(summary["substeps"].get<int>(), 4);
  const std::string text = console_report(study, results);
  EXPECT_NE(text.find("substeps per sample, each of fourth order, chosen"), std::string::npos) << text;
}

TEST(SubstepsOfACase, AreTakenAsStated) {
  const Study study = study_of(changed(oscillator, "settle: 0.2 s", "settle: 0.2 s\n  substeps: 2"));
  const auto results = run_study(study, "estimate");
  const auto summary = summarise(study, results)["estimation"];
  EXPECT_EQ(summary["substeps"], 2);
  EXPECT_EQ(summary["substeps_chosen"], false);
  EXPECT_FALSE(summary.contains("substep_bias"));
  EXPECT_NE(console_report(study, results).find("2 substeps per sample, each of fourth order, as stated"),
            std::string::npos);
  for (const std::string& wrong : {"0", "129", "many"})
    EXPECT_NE(problems_of(changed(oscillator, "settle: 0.2 s", "settle: 0.2 s\n  substeps: " + wrong))
                  .find("estimate.substeps"),
              std::string::npos);
}

TEST(SubstepsOfACase, TooFewAreAReasonForDoubt) {
  const Study study = study_of(oscillator);
  auto results = run_study(study, "estimate");
  const auto state_with = [&](double bias) {
    results.get<EstimationOutcome>().substeps = {
        .substeps = 128, .chosen = true, .bias = Eigen::VectorXd::Constant(1, bias), .limited = bias > 0.2};
    const Verdict verdict = verdict_of(study, results);
    for (const auto& reason : verdict.reasons())
      if (reason.code == "step_too_coarse") {
        EXPECT_EQ(reason.subject, "c.k3");
        EXPECT_NE(reason.text.find("128 substeps"), std::string::npos) << reason.text;
        return reason.state;
      }
    return VerdictState::consistent;
  };
  EXPECT_EQ(state_with(0.1), VerdictState::consistent);
  EXPECT_EQ(state_with(0.4), VerdictState::consistent);  // beyond the limit, but too small to matter
  EXPECT_EQ(state_with(0.8), VerdictState::suspicious);
  EXPECT_EQ(state_with(20.0), VerdictState::unusable);
}

TEST(StartOfACase, IsUnknownWhereTheSimulatedStructureIsLetGo) {
  const std::string released = changed(oscillator, "seed: 3}", "seed: 3, initial: {s.m: {displacement: 20 mm}}}");
  const Study study = study_of(released);
  const auto results = run_study(study, "estimate");
  ASSERT_TRUE(results.usable()) << results.why_unusable();
  const auto start = summarise(study, results)["estimation"]["start"];
  EXPECT_EQ(start["moving"], true);
  EXPECT_GT(start["displacement_std"].get<double>(), 2e-3);
  EXPECT_LT(start["displacement_std"].get<double>(), 0.2);
  EXPECT_NE(console_report(study, results).find("The structure moves at the first sample"), std::string::npos);
  const auto& unknowns = results.get<EstimationOutcome>().result.unknowns;
  EXPECT_LT(std::abs(unknowns.mean(0, 400) - 2e7), 3.0 * unknowns.deviation(0, 400));
  EXPECT_NEAR(results.get<EstimationOutcome>().consistency.mean_nis, 1.0, 0.25);
  // what the case states holds
  const auto stated = results_of(
      changed(released, "settle: 0.2 s", "settle: 0.2 s\n  initial_state: {s.m: {displacement: 20 mm}}"), "estimate");
  EXPECT_FALSE(stated.get<EstimationOutcome>().start.moving);
}

}  // namespace
}  // namespace kalfem::test
