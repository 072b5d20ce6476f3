// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "casefile/case_run.hpp"
#include "kalfem/diagnosis/judge_estimation.hpp"
#include "kalfem/report/console_report.hpp"
#include "kalfem/report/result_set.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/run_study.hpp"

// Noise that adapts, from the case to its results; and maximum likelihood on the same wrong noise.

namespace kalfem::test {
namespace {

/// Two masses under a known force; NOISE and ESTIMATE are filled in. The record has a noise of 0.05 mm and 0.3 m/s^2.
const std::string two_masses = R"(kalfem: 1
substructures:
  s:
    masses: {1: 1 kg, 2: 1 kg}
    springs:
      - {name: k1, from: ground, to: 1, stiffness: 2 kN/m, damping: 2 N s/m}
      - {name: k2, from: 1, to: 2, stiffness: 3 kN/m, damping: 2 N s/m}
excitation:
  f: {force: s.1, random: {rms: 10 N, band: [1, 15 Hz], fade_in: 0.2 s, seed: 2}}FORCE
sensors:
  x1: {displacement: s.1, noise: X_NOISE mm}
  a2: {acceleration: s.2, noise: A_NOISE m/s^2}
simulate: {duration: 20 s, sample_rate: 200 Hz, seed: 3}
estimate:
  diagnose: false
  second_thoughts: full
  settle: 10 s
  unknown:
    s.k2.stiffness: {initial: 2.5 kN/m, std: 20 %}
)";

constexpr double x_noise = 0.05, a_noise = 0.3;  // [mm], [m/s^2]

/// The case with noise that is stated `factor` times as large as it is.
std::string stated(double factor, const std::string& force = "") {
  auto text = changed(two_masses, "FORCE", force);
  text = changed(text, "X_NOISE", std::to_string(factor * x_noise));
  return changed(text, "A_NOISE", std::to_string(factor * a_noise));
}

const std::string unmodelled = "\n  g: {force: s.2, random: {rms: 5 N, band: [0.1, 80 Hz], seed: 5}}";

/// Estimates from the record that the true case gives.
StudyResults estimated(const std::string& estimate, double factor, const std::string& force = "") {
  const Study truth = study_of(stated(1.0, force));
  Study model = study_of(stated(factor) + estimate);
  StudyResults results = run_study(truth, "simulate");
  Record record = record_of(truth, results);
  for (auto& channel : record.channels) channel.noise *= factor;
  results.put(EstimationOutcome{});
  static_cast<RecordEstimate&>(results.get<EstimationOutcome>()) =
      estimate_record_thoroughly(model.problem, *model.augmented_model, record);
  return results;
}

double relative_nis(const RecordEstimate& estimate) {
  return estimate.consistency.mean_nis / estimate.consistency.expected_nis;
}

double error_in_deviations(const RecordEstimate& estimate) {
  const Eigen::Index last = estimate.result.unknowns.mean.cols() - 1;
  return std::abs(estimate.result.unknowns.mean(0, last) - 3000.0) /
         std::max(estimate.result.unknowns.deviation(0, last), estimate.robust_deviation[0]);
}

void expect_consistent(const RecordEstimate& estimate, const std::string& what) {
  ASSERT_FALSE(estimate.result.failure) << what;
  EXPECT_NEAR(relative_nis(estimate), 1.0, 0.1) << what;
}

void expect_right(const RecordEstimate& estimate, const std::string& what) {
  expect_consistent(estimate, what);
  EXPECT_LT(error_in_deviations(estimate), 3.0) << what;
}

TEST(AdaptiveNoiseCase, MakesWrongNoiseConsistent) {
  for (const double factor : {0.1, 10.0})
    expect_right(estimated("  adaptive_noise: {sensors: true}\n", factor).get<EstimationOutcome>(),
                 std::to_string(factor));
  // A force on one mass is no white noise on both, so nothing is asked of the stiffness.
  expect_consistent(estimated("  adaptive_noise: {process: true}\n", 1.0, unmodelled).get<EstimationOutcome>(),
                    "forces");
}

TEST(AdaptiveNoiseCase, MaximumLikelihoodMakesItConsistentToo) {
  for (const double factor : {0.1, 10.0})
    expect_right(estimated("    sensors.x1.noise: {initial: " + std::to_string(factor * x_noise) +
                               " mm}\n    sensors.a2.noise: {initial: " + std::to_string(factor * a_noise) + "}\n",
                           factor)
                     .get<EstimationOutcome>(),
                 std::to_string(factor));
  expect_consistent(estimated("    process_noise: {initial: 0.1}\n", 1.0, unmodelled).get<EstimationOutcome>(),
                    "forces");
}

TEST(AdaptiveNoiseCase, SaysWhereTheNoiseWentFarFromWhatWasStated) {
  const auto code_of = [](const RecordEstimate& estimate, const std::string& subject) {
    for (const auto& reason : verdict_of(estimate).reasons())
      if (reason.code == "noise_adapted_far" && reason.subject == subject) return reason.text;
    return std::string();
  };
  // Where both are far off, noise of a sensor may pass as process noise: each is asked by itself.
  const std::string text =
      code_of(estimated("  adaptive_noise: {sensors: true}\n", 0.1).get<EstimationOutcome>(), "a2");
  EXPECT_NE(text.find("the noise of 'a2' adapted from 0.03 to 0."), std::string::npos) << text;
  EXPECT_NE(code_of(estimated("  adaptive_noise: {process: true}\n", 1.0, unmodelled).get<EstimationOutcome>(),
                    "process noise")
                .find("stated as 0"),
            std::string::npos);
  const auto right = estimated("  adaptive_noise: {sensors: true, process: true}\n", 1.0);
  for (const char* subject : {"x1", "a2", "process noise"})
    EXPECT_EQ(code_of(right.get<EstimationOutcome>(), subject), "") << subject;
}

TEST(AdaptiveNoiseCase, IsInEveryResult) {
  const Study study = study_of(stated(1.0) + "  adaptive_noise: {sensors: true, process: true, memory: 1 s}\n");
  const auto results = run_study(study, "predict");
  const auto summary = summarise(study, results)["estimation"]["adaptive_noise"];
  const auto& course = *results.get<EstimationOutcome>().result.noise;
  const Eigen::Index last = course.sensors.cols() - 1;
  EXPECT_DOUBLE_EQ(summary["sensors"]["x1"]["last"].get<double>(), course.sensors(0, last));
  EXPECT_NEAR(summary["sensors"]["a2"]["stated"].get<double>(), a_noise, 1e-9);
  EXPECT_EQ(summary["sensors"]["a2"]["unit"], "m/s^2");
  EXPECT_LE(summary["sensors"]["a2"]["range"][0].get<double>(), summary["sensors"]["a2"]["last"].get<double>());
  EXPECT_DOUBLE_EQ(summary["process"]["last"].get<double>(), course.density_at(last));
  EXPECT_EQ(summary["process"]["stated"].get<double>(), 0.0);
  const std::string text = console_report(study, results);
  EXPECT_NE(text.find("Noise of a2: "), std::string::npos);
  EXPECT_NE(text.find("Process noise: "), std::string::npos);
  EXPECT_TRUE(results.get<EstimationOutcome>().process_noise.empty());
  EXPECT_FALSE(summarise(study_of(stated(1.0)), run_study(study_of(stated(1.0)), "predict"))["estimation"].contains(
      "adaptive_noise"));
}

}  // namespace
}  // namespace kalfem::test
