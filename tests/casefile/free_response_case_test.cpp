// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <random>

#include "casefile/record_cases.hpp"
#include "kalfem/identification/filter_run.hpp"
#include "kalfem/report/result_set.hpp"
#include "kalfem/steps/run_study.hpp"

// A mass that is held 40 mm up, released at 0.5 s, and swings about a rest position of 5 mm.
namespace kalfem::record_cases {
namespace {

constexpr double let_go_at = 0.5, rests_at = 0.005, lifted_to = 0.04, natural = 20.0, damping_ratio = 0.05;

double swinging(double t) {
  const double since = t - let_go_at, damped = natural * std::sqrt(1.0 - damping_ratio * damping_ratio);
  if (since < 0.0) return lifted_to;
  return rests_at + (lifted_to - rests_at) * std::exp(-damping_ratio * natural * since) *
                        (std::cos(damped * since) + damping_ratio * natural / damped * std::sin(damped * since));
}

const std::string released_case = R"(kalfem: 1
substructures:
  s: {masses: {m: 2 kg}, springs: [{name: k, from: ground, to: m, stiffness: 800 N/m, damping: 4 N s/m}]}
sensors:
  x: {displacement: s.m, noise: 0.05 mm}
record: {file: record.csv, sample_rate: 200 Hz, free_response: {delay: 0.05 s, threshold: 0.1 mm}}
estimate:
  unknown: {s.k.stiffness: {initial: 760 N/m, std: 20 %}, s.k.damping: {initial: 5 N s/m, std: 50 %}}
  initial_state_from_record: true
  initial_state: {s.m: {displacement_std: 0.1 mm, velocity_std: 20 mm/s}}
  settle: 0 s
)";

class FreeResponseCases : public RecordCase {
protected:
  /// The record of that length, with a push behind it that moves the mass 3 mm away for good.
  void write(double duration, double pushed_for = 0.0) {
    std::mt19937 generator(7);
    std::normal_distribution<double> normal(0.0, 5e-5);
    std::ofstream file(folder_ / "record.csv");
    file << "x\n";
    for (int k = 0; k < int((duration + pushed_for) * 200.0); ++k) {
      const double t = k / 200.0, since = t - duration;
      const double push = since < 0.0 ? 0.0 : 0.003 + 0.02 * std::exp(-2.0 * since) * std::sin(9.0 * since);
      file << swinging(t) + push + normal(generator) << "\n";
    }
  }
  [[nodiscard]] nlohmann::ordered_json run(const std::string& from = "", const std::string& to = "") {
    std::string text = released_case;
    if (!from.empty()) text.replace(text.find(from), from.size(), to);
    std::ofstream(folder_ / "case.yaml") << text;
    const Study study = load_study((folder_ / "case.yaml").string());
    const auto results = run_study(study, "predict");
    EXPECT_TRUE(results.complete()) << results.failure;
    return summarise(study, results);
  }
  /// Estimate less truth in standard deviations.
  static double off(const nlohmann::ordered_json& parameter, double truth) {
    return (parameter["estimate"].get<double>() - truth) / parameter["std"].get<double>();
  }
};

TEST_F(FreeResponseCases, ReleaseAndRestAreTold) {
  write(9.0);
  const auto summary = run();
  const auto& record = summary["record"];
  // the mass leaves 1 % of the excursion .015 s after it is let go, and five samples count
  EXPECT_NEAR(record["release_s"].get<double>(), let_go_at, 0.025);
  // exp(-t) falls to 1 % of the excursion of 65 mm, 0.65 of 35 mm, in 4 s.
  EXPECT_NEAR(record["rest_s"].get<double>(), let_go_at + 4.0, 0.12);
  // the noise of .05 mm over the rest of 4 s: found 1e-6
  EXPECT_NEAR(record["rest_positions"]["x"]["position"].get<double>(), rests_at, 3e-6);
  EXPECT_TRUE(record["rest_positions"]["x"]["std"].is_null());
  EXPECT_FALSE(summary["parameters"].contains("rest.x"));
  // three deviations of one record; found 1.0 of one
  EXPECT_LT(std::abs(off(summary["parameters"]["s.k.stiffness"], 800.0)), 3.0);
}

TEST_F(FreeResponseCases, ALaterNudgeMovesNothing) {
  write(9.0);
  const auto alone = run();
  write(9.0, 30.0);
  const auto nudged = run();
  EXPECT_EQ(nudged["record"]["release_s"], alone["record"]["release_s"]);
  // the same to a sample
  EXPECT_NEAR(nudged["record"]["rest_s"].get<double>(), alone["record"]["rest_s"].get<double>(), 0.011);
  // The filter stops soon after the motion has died out, not at the nudge.
  EXPECT_NEAR(nudged["record"]["samples_used"].get<double>(), alone["record"]["samples_used"].get<double>(), 1.0);
  EXPECT_LT(alone["record"]["samples_used"], alone["record"]["samples"]);
  for (const auto& [name, parameter] : alone["parameters"].items())
    EXPECT_LT(std::abs(off(nudged["parameters"][name], parameter["estimate"].get<double>())), 1e-6) << name;
}

TEST_F(FreeResponseCases, ARestPositionThatTheRecordDoesNotShowIsEstimated) {
  for (const std::string filter : {"auto", "ekf", "ukf"}) {
    write(2.2);
    const auto summary = run("settle: 0 s", "settle: 0 s\n  filter: " + filter);
    const auto& record = summary["record"];
    EXPECT_TRUE(record["rest_s"].is_null());
    const auto& rest = record["rest_positions"]["x"];
    const double deviation = rest["std"];
    // three deviations of one record; found .06 of one
    EXPECT_LT(std::abs(rest["position"].get<double>() - rests_at), 3.0 * deviation) << filter;
    // White noise of 0.05 mm in 320 samples: 0.05 / sqrt(320) = 0.003 mm, somewhat more beside four other unknowns.
    EXPECT_GT(deviation, 2.5e-6) << filter;
    EXPECT_LT(deviation, 8e-6) << filter;
    // three deviations of one record; found 1.0 and .6 of one
    EXPECT_LT(std::abs(off(summary["parameters"]["s.k.stiffness"], 800.0)), 3.0) << filter;
    EXPECT_LT(std::abs(off(summary["parameters"]["s.k.damping"], 4.0)), 3.0) << filter;
    // 320 samples of one channel: two standard errors of sqrt(2 / 320)
    EXPECT_NEAR(summary["estimation"]["nis"]["mean"].get<double>(), 1.0, 0.16) << filter;
  }
}

/// Displacements are measured from a rest position that is not known: nor are they known at the start.
TEST_F(FreeResponseCases, TheStartIsNoBetterKnownThanTheRestPosition) {
  const auto deviation_at_start = [&](double duration) {
    write(duration);
    std::ofstream(folder_ / "case.yaml") << released_case;
    const Study study = load_study((folder_ / "case.yaml").string());
    const auto run = make_filter_run(study.problem, *study.augmented_model, record_of(study, {}));
    const double rest =
        study.record->free_response->rest_is_unknown() ? study.record->free_response->deviation[0] : 0.0;
    EXPECT_EQ(rest > 0.0, duration < 5.0);
    return std::pair(run.choice.augmented_model->options().prior.displacement_deviation[0], std::hypot(1e-4, rest));
  };
  for (const double duration : {2.2, 9.0}) {
    const auto [found, expected] = deviation_at_start(duration);
    EXPECT_DOUBLE_EQ(found, expected) << duration;
  }
}

TEST_F(FreeResponseCases, ThePriorOfARestPositionMayBeGiven) {
  write(2.2);
  const double narrow = 1e-9;
  const auto summary = run("threshold: 0.1 mm", "threshold: 0.1 mm, rest_std: 1e-9 m");
  // a record tells nothing of a nanometre
  EXPECT_NEAR(summary["parameters"]["rest.x"]["std"].get<double>(), narrow, 1e-6 * narrow);
}

TEST_F(FreeResponseCases, SeveralPassesAndTheOpenLoopKnowTheRestPosition) {
  write(2.2);
  const auto summary = run("settle: 0 s", "settle: 0 s\n  estimate_initial_state: true\n  passes: 2");
  // three deviations of 3 um: found 4e-7
  EXPECT_LT(std::abs(summary["record"]["rest_positions"]["x"]["position"].get<double>() - rests_at), 1e-5);
  // What is left is the noise: 0.05 mm against a swing of about 10 mm rms.
  EXPECT_LT(summary["estimation"]["open_loop"]["x"]["nrmse"].get<double>(), 0.01);
}

}  // namespace
}  // namespace kalfem::record_cases
