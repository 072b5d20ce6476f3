// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/inference/report.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "kalfem/steps/inference/outcome.hpp"
#include "steps/sample_inference.hpp"

namespace kalfem {
namespace {

using Eigen::VectorXd;
using Json = nlohmann::ordered_json;

constexpr double infinity = std::numeric_limits<double>::infinity(), unknown = std::numeric_limits<double>::quiet_NaN();

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// A page of an inference alone.
std::string page_of(const InferenceOutcome& outcome) {
  return render_html({.title = "Inference", .summary = "s", .sections = {inference_section(outcome)}});
}

/// What every outcome owes, however little it found.
void expect_sound(const InferenceOutcome& outcome) {
  const std::string json = inference_summary(outcome).dump();
  EXPECT_FALSE(contains(json, "nan") || contains(json, "inf,")) << json;
  const std::string text = console_inference(outcome);
  EXPECT_FALSE(contains(text, "nan") || contains(text, "inf ")) << text;
  const Section section = inference_section(outcome);
  for (const auto& item : section.items) {
    if (const auto* table = std::get_if<Table>(&item)) EXPECT_FALSE(table->rows.empty()) << table->title;
    if (const auto* chart = std::get_if<Chart>(&item))
      EXPECT_FALSE(chart->series.empty() || chart->series[0].y.empty());
  }
  const std::string page = page_of(outcome);
  EXPECT_FALSE(contains(page.substr(page.find("<main"), page.find("</main>") - page.find("<main")), "nan")) << page;
}

TEST(InferenceSummary, HoldsEveryNumberUnderItsName) {
  const auto outcome = sample_inference();
  const Json summary = inference_summary(outcome);
  const auto& k = summary["parameters"]["suspension.k"];
  const auto& posterior = outcome.posterior[0];
  EXPECT_EQ(k["mean"], posterior.mean);
  EXPECT_EQ(k["std"], posterior.deviation);
  EXPECT_EQ(k["quantiles"]["2.5%"], posterior.q2_5);
  EXPECT_EQ(k["quantiles"]["16%"], posterior.q16);
  EXPECT_EQ(k["quantiles"]["50%"], posterior.median);
  EXPECT_EQ(k["quantiles"]["84%"], posterior.q84);
  EXPECT_EQ(k["quantiles"]["97.5%"], posterior.q97_5);
  EXPECT_EQ(k["prior"]["mean"], 2e5);
  EXPECT_EQ(k["prior"]["std"], 4e4);
  EXPECT_EQ(k["most_probable"], 2.1e5);
  EXPECT_EQ(k["true"], 2.105e5);
  EXPECT_EQ(k["unit"], "N/m");
  EXPECT_EQ(k["z"], (posterior.mean - 2.105e5) / posterior.deviation);
  EXPECT_EQ(k["r_hat"], 1.002);
  EXPECT_EQ(k["ess_bulk"], 1100.0);
  EXPECT_EQ(k["ess_tail"], 900.0);
  EXPECT_TRUE(summary["parameters"]["body.damping"]["true"].is_null());
  EXPECT_FALSE(summary["parameters"]["body.damping"].contains("z"));
  EXPECT_EQ(summary["correlation"]["names"][1], "suspension.mu_k1");
  EXPECT_EQ(summary["correlation"]["matrix"][1][2], outcome.correlation(1, 2));
  EXPECT_EQ(summary["log_evidence"], 8399.4);
  EXPECT_EQ(summary["log_evidence_std"], 0.06);
  EXPECT_EQ(summary["log_likelihood"], 8421.0);
  EXPECT_EQ(summary["samples"], 1200);
  EXPECT_TRUE(summary["pareto_k"].is_null());
  EXPECT_EQ(summary["evaluations"], 1640);
  EXPECT_EQ(summary["warnings"][0], outcome.warnings[0]);
  EXPECT_EQ(summary["seconds"], 12.3);
}

TEST(InferenceSummary, HoldsWhatWasComputedBesideThePosterior) {
  const auto outcome = sample_inference();
  const Json summary = inference_summary(outcome);
  const auto& after = summary["identifiability"]["after"];
  EXPECT_EQ(after["text"], outcome.after->text);
  EXPECT_NEAR(after["cramer_rao"]["suspension.mu_k1"].get<double>(), 0.8, 1e-12);
  EXPECT_EQ(after["combinations"].size(), 4u);
  EXPECT_EQ(after["combinations"][0]["words"], outcome.after->combinations[0].words);
  EXPECT_EQ(after["combinations"][3]["determined"], false);
  EXPECT_EQ(summary["beside_filter"]["suspension.mu_k2"]["std_ratio"], 0.55);
  EXPECT_EQ(summary["beside_filter"]["suspension.mu_k2"]["agrees"], false);
  EXPECT_EQ(summary["beside_filter"]["suspension.k"]["agrees"], true);
  EXPECT_EQ(summary["profiles"]["suspension.mu_k1"]["interval_95"], (Json{18.43, 21.57}));
  EXPECT_EQ(summary["profiles"]["suspension.mu_k1"]["values"].size(), 21u);
  EXPECT_EQ(summary["predictive"]["a3"]["coverage_95"], 0.953);
  EXPECT_EQ(summary["laws"]["connector"], "suspension");
  const auto& second = summary["laws"]["ranking"][1];
  EXPECT_EQ(second["log_evidence"], 8392.5);
  EXPECT_EQ(second["log_evidence_std"], 0.07);
  EXPECT_EQ(second["words"], "very strong");
  EXPECT_EQ(second["occam"], -14.2);
  EXPECT_EQ(second["validation"]["one_step_nrmse"], 0.043);
  EXPECT_TRUE(second["validation"]["open_loop_nrmse"].is_null());
  EXPECT_EQ(second["parameters"]["suspension.k"]["std"], 900.0);
  EXPECT_TRUE(second["failure"].is_null());
  const auto& failed = summary["laws"]["ranking"][2];
  EXPECT_TRUE(failed["log_evidence"].is_null() && failed["probability"].is_null());
  EXPECT_EQ(failed["failure"], "no sample of the prior has a likelihood");
  EXPECT_EQ(summary["sensitivity"]["frequency.1"]["total"]["suspension.k"]["lower"], 0.8);
  EXPECT_EQ(summary["sensitivity"]["frequency.1"]["first"]["suspension.mu_k2"]["value"], 0.1);
}

TEST(InferenceReport, AnswersFirst) {
  const auto answer = inference_answer(sample_inference());
  EXPECT_TRUE(contains(answer, "The data determine 3 of 4 parameters: suspension.k = "));
  EXPECT_TRUE(contains(answer, "The data tell little of body.damping ("));
  EXPECT_TRUE(contains(answer, "Of 3 laws for 'suspension', saturating is the most probable (99.90 %)."));
  EXPECT_TRUE(contains(answer, "The evidence against the next one, linear, is very strong."));
  EXPECT_TRUE(contains(answer, "One warning"));
  auto two = sample_inference();
  two.prior.resize(2);
  two.posterior.resize(2);
  EXPECT_TRUE(contains(inference_answer(two), "The data determine both parameters: suspension.k = "));
}

TEST(InferenceReport, WarnsOfLaws) {
  auto outcome = sample_inference();
  outcome.laws->laws[1].warnings = {"few samples"};
  EXPECT_EQ(inference_warnings(outcome),
            (std::vector<std::string>{"the record is short: 800 samples", "law linear: few samples"}));
  EXPECT_TRUE(contains(console_inference(outcome), "Warning: law linear: few samples\n"));
}

TEST(InferenceReport, SaysWhereTheFilterDiffers) {
  auto outcome = sample_inference();
  EXPECT_TRUE(
      contains(filter_words(outcome),
               "suspension.mu_k2: the filter's mean lies 0.6 posterior deviations away, its deviation is 0.55"));
  outcome.beside_filter.pop_back();
  EXPECT_EQ(filter_words(outcome), "The filter's normal distribution agrees with the posterior.");
}

TEST(InferenceReport, LeavesOutColumnsWithoutNumbers) {
  auto outcome = sample_inference();
  EXPECT_EQ(posterior_table(outcome).columns.size(), 7u);
  outcome.truths.assign(4, std::nullopt);
  EXPECT_EQ(posterior_table(outcome).columns,
            (std::vector<std::string>{"parameter", "prior", "posterior", "95 % interval", "std / prior std"}));
  const auto laws = law_table(*outcome.laws);
  EXPECT_EQ(std::ranges::count(laws.columns, "open loop"), 0);
  EXPECT_EQ(laws.rows[2][6], "not known: no sample of the prior has a likelihood");
}

TEST(InferenceReport, OrdersOutputsParametersByTheirTotalIndex) {
  const auto outcome = sample_inference();
  const auto table = sobol_table(outcome, outcome.sensitivity[0]);
  EXPECT_EQ(table.title, "Sobol' indices of frequency.1 [Hz]");
  EXPECT_EQ(table.rows[0],
            (std::vector<std::string>{"suspension.k", "0.810", "0.770 to 0.850", "0.860", "0.800 to 0.900"}));
  EXPECT_EQ(table.rows[1][0], "suspension.mu_k2");
  EXPECT_EQ(table.rows[3][0], "body.damping");
}

TEST(WithDeviation, WritesTheDigitsThatTheDeviationJustifies) {
  EXPECT_EQ(with_deviation(29.9712, 0.0931), "29.971 ± 0.093");
  EXPECT_EQ(with_deviation(29.9712, 0.0996), "29.97 ± 0.10");
  EXPECT_EQ(with_deviation(501.2, 23.4), "501 ± 23");
  EXPECT_EQ(with_deviation(-0.5, 2.0), "-0.5 ± 2.0");
  EXPECT_EQ(with_deviation(209968.2, 884.8), "209970 ± 880");
  EXPECT_EQ(with_deviation(2.1e11, 3.2e9), "2.100e+11 ± 3.2e+09");
  EXPECT_EQ(with_deviation(2.1e-5, 3.2e-6), "2.10e-05 ± 3.2e-06");
  EXPECT_EQ(with_deviation(3.0, 0.0), "3");
  EXPECT_EQ(with_deviation(3.0, unknown), "3");
  EXPECT_EQ(with_deviation(unknown, 1.0), "-");
}

TEST(InferenceReport, ShowsEverythingOnThePage) {
  expect_sound(sample_inference());
  const std::string page = page_of(sample_inference());
  for (const char* part :
       {"What the data tell of the parameters", "Posterior, pair by pair", "Convergence of the chains",
        "Profile likelihood of suspension.mu_k1", "95.30 % of the measured samples", "Laws of ", "frequency.1 [Hz]",
        "Warning: the record is short"})
    EXPECT_TRUE(contains(page, part)) << part;
}

TEST(InferenceReport, HoldsOneParameter) {
  InferenceOutcome outcome;
  outcome.samples = sample_draws(1, 200);
  outcome.samples.names.resize(1);
  outcome.samples.values = outcome.samples.values.topRows(1).eval();
  outcome.posterior = summarise_samples(outcome.samples);
  outcome.correlation = posterior_correlation(outcome.samples);
  expect_sound(outcome);
  EXPECT_TRUE(contains(inference_answer(outcome), "The data determine the parameter: suspension.k = "));
}

TEST(InferenceReport, HoldsNothing) {
  expect_sound({});
  EXPECT_TRUE(inference_section({}).items.empty());
  InferenceOutcome outcome;
  outcome.prior = {normal_summary("k", 3.0, 1.0)};
  outcome.warnings = {"the search found no likelihood"};
  expect_sound(outcome);
  EXPECT_EQ(inference_answer(outcome), "There is no posterior: the search found no likelihood.");
  EXPECT_TRUE(inference_summary(outcome)["parameters"]["k"]["mean"].is_null());
}

TEST(InferenceReport, HoldsSamplesThatDoNotVary) {
  auto outcome = sample_inference();
  outcome.samples.values = outcome.samples.values.col(0).replicate(1, outcome.samples.values.cols()).eval();
  outcome.posterior = summarise_samples(outcome.samples);
  outcome.correlation = posterior_correlation(outcome.samples);
  outcome.convergence.assign(4, {infinity, 0.0, unknown});
  expect_sound(outcome);
}

TEST(InferenceReport, HoldsNumbersThatAreNotFinite) {
  auto outcome = sample_inference();
  outcome.samples.values.row(1).setConstant(unknown);
  outcome.posterior[1] = normal_summary("suspension.mu_k1", unknown, unknown);
  outcome.posterior[2].deviation = infinity;
  outcome.prior[0].deviation = infinity;
  outcome.correlation.setConstant(unknown);
  outcome.log_evidence = -infinity;
  outcome.log_evidence_deviation = unknown;
  outcome.effective_samples = unknown;
  outcome.pareto_k = infinity;
  outcome.most_probable.setConstant(unknown);
  outcome.log_likelihood = unknown;
  outcome.beside_filter[0].mean_difference = unknown;
  outcome.beside_filter[1].deviation_ratio = infinity;
  outcome.profiles[0].log_likelihood.setConstant(-infinity);
  outcome.profiles[0].lower = {};
  outcome.bands[0].mean.setConstant(unknown);
  outcome.bands[0].lower.setConstant(unknown);
  outcome.bands[0].coverage = unknown;
  outcome.after->cramer_rao.setConstant(infinity);
  outcome.laws->laws[0].log_evidence = -infinity;
  outcome.laws->laws[0].probability = unknown;
  outcome.laws->laws[1].validation = unknown;
  outcome.sensitivity[0].indices.total[1].value = unknown;
  outcome.seconds = unknown;
  expect_sound(outcome);
  EXPECT_TRUE(contains(inference_answer(outcome), "No law of 'suspension' has an evidence."));
}

TEST(InferenceReport, HoldsListsThatAreTooShort) {
  auto outcome = sample_inference();
  outcome.units.clear();
  outcome.truths.clear();
  outcome.convergence.clear();
  outcome.correlation.resize(0, 0);
  outcome.most_probable.resize(0);
  outcome.prior.clear();
  outcome.prior_marginals.clear();
  outcome.profiles[0].values.resize(0);
  outcome.profiles[0].log_likelihood.resize(0);
  outcome.bands[0].measured.resize(0);
  outcome.laws->laws.clear();
  outcome.sensitivity[0].indices.first.clear();
  expect_sound(outcome);
}

}  // namespace
}  // namespace kalfem
