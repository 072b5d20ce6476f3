// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "base/scratch_folder.hpp"
#include "diagnosis/case_family.hpp"
#include "kalfem/diagnosis/candidates.hpp"
#include "kalfem/diagnosis/left_out_predictions.hpp"
#include "kalfem/records/clock_lag.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/run_study.hpp"

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// The chain measured for two seconds, once for all tests.
class Diagnoses : public testing::Test {
protected:
  static void SetUpTestSuite() {
    family = chain_family();
    family.duration = 2.0;
    family.noise = 0.05;
    const ScratchFolder folder("diagnosis-truth");
    clean = measure(family, {}, 1, folder);
  }

  /// The run of a case of this measurement.
  static StudyResults run(const Measurement& measurement, const Changes& changes = {}, const CaseFamily& of = family) {
    const ScratchFolder folder("diagnosis");
    return run_study(load_study(write_case(of, measurement, changes, folder).string()), "estimate");
  }

  static CaseFamily with_unknown_delay_of_a11() {
    CaseFamily with_delay = family;
    auto& text = with_delay.estimate;
    text.insert(text.find("  settle"), "    sensors.a11.delay: {initial: 0 s, std: 10 ms}\n");
    return with_delay;
  }

  /// "code subject" of the first reason.
  static std::string first_reason(const StudyResults& results) {
    const auto reasons = results.verdict.reasons();
    return reasons.empty() ? "" : reasons.front().code + " " + reasons.front().subject;
  }

  static inline CaseFamily family;
  static inline Measurement clean;
};

TEST_F(Diagnoses, AreNotMadeWhereNothingIsWrong) {
  const auto results = run(clean);
  EXPECT_EQ(results.verdict.state(), VerdictState::consistent) << first_reason(results);
  EXPECT_FALSE(results.get<EstimationOutcome>().diagnosis);
}

/// A parameter that an updating found from the record is not one that the case holds fixed.
TEST_F(Diagnoses, DoNotCallAnUpdatedParameterFixed) {
  const ScratchFolder folder("diagnosis-updated");
  const Study study = load_study(write_case(family, clean, {}, folder).string());
  DiagnosisInput input{.problem = study.problem, .parts = study.structure->parts, .record = {}};
  const std::string updated = "wheel.k_w.stiffness";
  const auto blames_it = [&] {
    return std::ranges::any_of(model_hypotheses(input, {}), [&](const Hypothesis& each) {
      return each.code == "fixed_parameter" && each.subject.find(updated) != std::string::npos;
    });
  };
  EXPECT_TRUE(blames_it());
  input.updated = {updated};
  EXPECT_FALSE(blames_it());
}

TEST_F(Diagnoses, NameASensorOfTheWrongSign) {
  auto wrong = clean;
  wrong.sensors.values.row(2) *= -1.0;
  const auto results = run(wrong);
  EXPECT_EQ(first_reason(results), "sensor_sign a7");
  EXPECT_EQ(results.verdict.state(), VerdictState::unusable);
  // Without it the filter is consistent, and others leave far more unexplained: one unit of log-likelihood a sample.
  const auto& tested = results.get<EstimationOutcome>().diagnosis->tested;
  EXPECT_NEAR(tested[0].mean_nis, 4.0, 0.4);
  EXPECT_GT(tested[0].gain, tested[1].gain + 2000.0);
}

TEST_F(Diagnoses, NameAUnitAndFindAGain) {
  auto in_g = clean;
  in_g.sensors.values.row(0) /= 9.80665;
  EXPECT_EQ(first_reason(run(in_g)), "sensor_unit a3");
  auto too_large = clean;
  too_large.sensors.values.row(0) *= 1.3;
  const auto results = run(too_large);
  EXPECT_EQ(first_reason(results), "sensor_gain a3");
  EXPECT_NEAR(results.get<EstimationOutcome>().diagnosis->tested[0].value, 1.3, 0.03);
}

TEST_F(Diagnoses, FindADelay) {
  auto late = clean;
  const Eigen::RowVectorXd given = late.sensors.values.row(3);
  late.sensors.values.row(3).tail(given.size() - 12) = given.head(given.size() - 12);
  const auto results = run(late);
  EXPECT_EQ(first_reason(results), "sensor_delay a11");
  EXPECT_EQ(results.get<EstimationOutcome>().diagnosis->tested[0].value, 12.0);
}

/// Whole samples leave something, so parts of them are tried until nothing is left.
TEST_F(Diagnoses, FindADelayBetweenTwoSamples) {
  auto late = clean;
  const Eigen::VectorXd moved = with_lag(late.sensors, 3, {.delay = 2.4 / late.sensors.sample_rate});
  late.sensors.values.row(3) = moved.array().isFinite().select(moved, 0.0).transpose();
  const auto results = run(late);
  EXPECT_EQ(first_reason(results), "sensor_delay a11");
  const auto& diagnosis = *results.get<EstimationOutcome>().diagnosis;
  EXPECT_NEAR(diagnosis.tested[0].value, 2.4, 0.15);
  EXPECT_TRUE(diagnosis.together.empty());
}

TEST_F(Diagnoses, NameSensorsThatAreExchanged) {
  auto exchanged = clean;
  exchanged.sensors.values.row(1).swap(exchanged.sensors.values.row(2));
  EXPECT_EQ(first_reason(run(exchanged)), "sensors_swapped a5, a7");
}

TEST_F(Diagnoses, NameTheExcitation) {
  auto turned = clean;
  turned.excitations.values *= -1.0;
  EXPECT_EQ(first_reason(run(turned)), "excitation_sign road");
}

TEST_F(Diagnoses, FindAFixedParameter) {
  const auto results = run(clean, {{"stiffness: 20 kN/m", "stiffness: 26 kN/m"}});
  EXPECT_EQ(first_reason(results), "fixed_parameter wheel.k_w.stiffness");
  EXPECT_NEAR(results.get<EstimationOutcome>().diagnosis->tested[0].value, 20.0 / 26.0, 0.03);
}

/// Neither one explains the record without the other.
TEST_F(Diagnoses, NameTwoMistakesAtOnce) {
  auto wrong = clean;
  wrong.sensors.values.row(2) *= -1.0;
  const auto results = run(wrong, {{"stiffness: 20 kN/m", "stiffness: 26 kN/m"}});
  const auto together = results.get<EstimationOutcome>().diagnosis->together;
  ASSERT_EQ(together.size(), 2);
  EXPECT_EQ(together[0].code + " " + together[0].subject, "sensor_sign a7");
  EXPECT_EQ(together[1].code + " " + together[1].subject, "fixed_parameter wheel.k_w.stiffness");
  EXPECT_NEAR(together[1].value, 20.0 / 26.0, 0.03);
  EXPECT_NEAR(together[1].mean_nis, 4.0, 0.4);
  EXPECT_GT(together[1].nis_before, 5.0);
  const auto reasons = results.verdict.reasons();
  EXPECT_EQ(reasons[0].code, "sensor_sign");
  EXPECT_EQ(reasons[1].code, "fixed_parameter");
  EXPECT_NE(reasons[0].text.find("wheel.k_w.stiffness"), std::string::npos) << reasons[0].text;
}

/// The delay that the run found beside the wrong sign is none of the record's. It is found again with the sign undone,
/// and is no second mistake.
TEST_F(Diagnoses, FindUnknownClocksAgainBesideAMistake) {
  auto wrong = clean;
  wrong.sensors.values.row(2) *= -1.0;
  const Eigen::RowVectorXd given = wrong.sensors.values.row(3);
  wrong.sensors.values.row(3).tail(given.size() - 12) = given.head(given.size() - 12);
  CaseFamily with_clock = family;
  with_clock.estimate.insert(with_clock.estimate.find("  settle"),
                             "    sensors.a11.delay: {initial: 0 s, std: 10 ms}\n");
  const auto results = run(wrong, {}, with_clock);
  const auto& diagnosis = *results.get<EstimationOutcome>().diagnosis;
  EXPECT_EQ(first_reason(results), "sensor_sign a7");
  EXPECT_TRUE(diagnosis.together.empty());
  EXPECT_TRUE(diagnosis.one_explains_all());
  EXPECT_NEAR(diagnosis.tested[0].mean_nis, 4.0, 0.4);
}

TEST_F(Diagnoses, FindUnknownClocksAgainBesideTwoMistakes) {
  auto wrong = clean;
  wrong.sensors.values.row(2) *= -1.0;
  const Eigen::RowVectorXd given = wrong.sensors.values.row(3);
  wrong.sensors.values.row(3).tail(given.size() - 12) = given.head(given.size() - 12);
  const auto results = run(wrong, {{"stiffness: 20 kN/m", "stiffness: 26 kN/m"}}, with_unknown_delay_of_a11());
  const auto together = results.get<EstimationOutcome>().diagnosis->together;
  ASSERT_EQ(together.size(), 2);
  EXPECT_EQ(together[0].code + " " + together[0].subject, "sensor_sign a7");
  EXPECT_EQ(together[1].code + " " + together[1].subject, "fixed_parameter wheel.k_w.stiffness");
  EXPECT_NEAR(together[1].mean_nis, 4.0, 0.4);
}

TEST(Likeness, FindsLagSignAndGain) {
  Eigen::RowVectorXd x(400), y(400);
  for (Index k = 0; k < 400; ++k) x[k] = std::sin(0.37 * double(k)) + std::sin(0.113 * double(k * k % 331));
  for (Index k = 0; k < 400; ++k) y[k] = -2.0 * x[std::max<Index>(0, k - 7)] + 0.5;
  const auto found = likeness(y, x, 20);
  EXPECT_EQ(found.lag, 7);
  EXPECT_LT(found.correlation, -0.95);
  EXPECT_NEAR(likeness(-3.0 * x, x, 20).gain, -3.0, 1e-12);
  // A channel with gaps, and one without a single number.
  y.segment(50, 60).setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(likeness(y, x, 20).lag, 7);
  EXPECT_FALSE(likeness(MatrixXd::Constant(1, 400, std::numeric_limits<double>::quiet_NaN()), x, 20).known);
}

TEST(UnitMistakes, AreNamed) {
  EXPECT_EQ(unit_mistake(1.0 / 9.80665), "it is in g, not in m/s^2");
  EXPECT_EQ(unit_mistake(1.3), std::nullopt);
  EXPECT_EQ(unit_factors_near(-1020.0, 0.1), std::vector<double>{1000.0});
  EXPECT_EQ(unit_factors_near(2.0, 0.1), std::vector<double>{});
  EXPECT_EQ(unit_factors_near(std::nullopt, 0.1).front(), 1000.0);
}

}  // namespace
}  // namespace kalfem::test
