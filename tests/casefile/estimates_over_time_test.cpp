// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "casefile/case_run.hpp"
#include "kalfem/identification/walked_range.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/report/result_set.hpp"
#include "kalfem/steps/estimation/report.hpp"
#include "kalfem/steps/run_study.hpp"

// What is told of unknowns along a record: natural frequencies with their bands, and ranges of unknowns that walk.

namespace kalfem::test {
namespace {

using Eigen::Index;

/// One mass on a spring of 4 kN/m, and a second one on top of it.
const std::string towers = R"(kalfem: 1
substructures:
  s:
    masses: {1: 2 kg, 2: 1 kg}
    springs:
      - {name: low, from: ground, to: 1, stiffness: 4 kN/m, damping: 8}
      - {name: high, from: 1, to: 2, stiffness: 3 kN/m, damping: 6}
excitation:
  push: {force: s.1, random: {rms: 20 N, band: [0.5, 15 Hz], seed: 4}}
sensors:
  a1: {acceleration: s.1, noise: 3 %}
  a2: {acceleration: s.2, noise: 3 %}
simulate: {duration: 6 s, sample_rate: 200 Hz, tolerance: 1e-4}
estimate:
  settle: 1 s
  substeps: 4
  unknown: {s.low.stiffness: {initial: 5 kN/m, std: 30 %}, s.1.mass: {initial: 2.4 kg, std: 20 %}}
report: {frequencies: 2}
)";

/// Squared circular frequencies of the two masses: the roots of a quadratic.
double closed_form(double k1, double k2, double m1, double m2, int mode) {
  const double a = m1 * m2, b = -(m1 * k2 + m2 * (k1 + k2)), c = k1 * k2;
  const double root = std::sqrt(b * b - 4.0 * a * c);
  return std::sqrt((-b + (mode == 0 ? -root : root)) / (2.0 * a)) / (2.0 * std::numbers::pi);
}

TEST(FrequencyCourse, IsTheClosedFormOfTheEstimatesWithItsDeviation) {
  const auto results = results_of(towers);
  ASSERT_TRUE(results.complete()) << results.failure;
  const auto& outcome = results.get<EstimationOutcome>();
  ASSERT_TRUE(outcome.frequencies.has_value());
  const auto& course = *outcome.frequencies;
  ASSERT_EQ(course.frequency.rows(), 2);
  const Index last = course.time.size() - 1, sample = outcome.result.unknowns.mean.cols() - 1;
  EXPECT_GE(course.time[0], 1.0);  // after settling
  EXPECT_DOUBLE_EQ(course.time[last], outcome.measurements.time(sample));
  const double k = outcome.result.unknowns.mean(0, sample), m = outcome.result.unknowns.mean(1, sample);
  const Index first = outcome.augmented_model->layout().unknown();
  // The filter's state holds transforms of the unknowns: their correlation with the unknowns' own deviations.
  const Eigen::Matrix2d of_state = outcome.result.final_covariance.block(first, first, 2, 2);
  const Eigen::Vector2d scale =
      outcome.result.unknowns.deviation.col(sample).cwiseQuotient(of_state.diagonal().cwiseSqrt());
  const Eigen::Matrix2d covariance = scale.asDiagonal() * of_state * scale.asDiagonal();
  for (int mode = 0; mode < 2; ++mode) {
    const auto frequency = [&](double stiffness, double mass) { return closed_form(stiffness, 3e3, mass, 1.0, mode); };
    EXPECT_NEAR(course.frequency(mode, last), frequency(k, m), 1e-9);
    const Eigen::Vector2d slope((frequency(1.001 * k, m) - frequency(0.999 * k, m)) / (0.002 * k),
                                (frequency(k, 1.001 * m) - frequency(k, 0.999 * m)) / (0.002 * m));
    const double expected = std::sqrt(slope.dot(covariance * slope));
    EXPECT_NEAR(course.deviation(mode, last) / expected, 1.0, 1e-3);  // difference quotients of both
    EXPECT_NEAR(course.frequency(mode, last), closed_form(4e3, 3e3, 2.0, 1.0, mode), 4.0 * expected);
  }
}

TEST(FrequencyCourse, StandsInTheSummaryAndOnThePage) {
  const auto study = study_of(towers);
  const auto results = run_study(study, "estimate");
  const auto summary = summarise(study, results);
  ASSERT_EQ(summary["frequencies"].size(), 2U);
  EXPECT_NEAR(summary["frequencies"][0]["estimate"].get<double>(), closed_form(4e3, 3e3, 2.0, 1.0, 0), 0.1);
  const auto page = make_page(study, results);
  EXPECT_TRUE(std::ranges::any_of(page.sections, [](const Section& section) {
    return section.heading == "Natural frequencies over the record" && section.items.size() == 3;
  }));
}

/// A spring that softens from 4 kN/m by a quarter and recovers, over 8 s.
const std::string softening = R"(kalfem: 1
substructures: {s: {masses: {1: 2 kg}, springs: [{name: c, from: ground, to: 1, damping: 8}]}}
connectors:
  bank:
    {from: s.ground, to: s.1, law: expression, force: "k*x*FACTOR", parameters: {k: 4000}SIGNALS}
excitation:
  push: {force: s.1, random: {rms: 20 N, band: [0.5, 15 Hz], seed: 4}}
sensors:
  a1: {acceleration: s.1, noise: 3 %}
simulate: {duration: 8 s, sample_rate: 200 Hz, tolerance: 1e-4}
estimate:
  settle: 1 s
  substeps: 4
  diagnose: false
  unknown: {bank.k: {initial: 4500, std: 30 %, random_walk: 400}}
)";

TEST(WalkedRange, HoldsWhereTheStiffnessWent) {
  const auto model = study_of(changed(changed(softening, "*FACTOR", ""), "SIGNALS", ""));
  const auto truth =
      study_of(changed(changed(softening, "FACTOR", "(1 - 0.25*sin(0.3927*t)^2)"), "SIGNALS", ", signals: {t: time}"));
  const auto simulated = run_study(truth, "simulate");
  const auto estimate = estimate_record(model.problem, *model.augmented_model, record_of(truth, simulated));
  const auto range = walked_range(estimate, 0);
  ASSERT_TRUE(range.has_value());
  // 4 kN/m at either end, 3 kN/m in the middle; the walk lags by about a period
  EXPECT_NEAR(range->least, 3000.0, 250.0);
  EXPECT_NEAR(range->greatest, 4000.0, 250.0);
  EXPECT_LT(range->lower, range->least);
  EXPECT_GT(range->upper, range->greatest);
}

TEST(WalkedRange, ReplacesTheLastSampleInTheTable) {
  const std::string walking = changed(changed(softening, "*FACTOR", ""), "SIGNALS", "");
  const auto study = study_of(walking);
  const auto results = run_study(study, "estimate");
  const auto parameter = summarise(study, results)["parameters"]["bank.k"];
  const auto range = walked_range(results.get<EstimationOutcome>(), 0);
  ASSERT_TRUE(range.has_value());
  EXPECT_DOUBLE_EQ(parameter["range"][0].get<double>(), range->least);
  EXPECT_DOUBLE_EQ(parameter["range_95"][1].get<double>(), range->upper);
  const auto table = parameter_table(study, results.get<EstimationOutcome>());
  EXPECT_EQ(table.rows[0][3], four_digits(range->least) + " to " + four_digits(range->greatest));
  // A constant has one value.
  const auto constant = study_of(changed(walking, ", random_walk: 400", ""));
  const auto held = run_study(constant, "estimate");
  EXPECT_FALSE(walked_range(held.get<EstimationOutcome>(), 0).has_value());
  EXPECT_FALSE(summarise(constant, held)["parameters"]["bank.k"].contains("range"));
}

}  // namespace
}  // namespace kalfem::test
