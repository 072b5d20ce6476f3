// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "casefile/case_run.hpp"
#include "kalfem/identification/freed_numbers.hpp"
#include "kalfem/report/console_report.hpp"
#include "kalfem/report/result_set.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/run_study.hpp"
#include "kalfem/steps/simulation/outcome.hpp"

// estimate.free of a case: what becomes of a number that its record asks to change.

namespace kalfem::test {
namespace {

std::string two_masses(const std::string& mass, const std::string& settings) {
  return R"(kalfem: 1
substructures:
  s:
    masses: {a: 1 kg, b: )" +
         mass + R"(}
    springs:
      - {name: k1, from: ground, to: a, stiffness: 2000, damping: 3}
      - {name: k2, from: a, to: b, stiffness: 1500, damping: 2}
connectors:
  mount: {from: s.b, to: s.ground, law: cubic, parameters: {k: 400, k3: 4e6, c: 1}}
excitation:
  shaker: {force: s.a, random: {rms: 4 N, band: [1, 12 Hz], seed: 3}}
sensors:
  a1: {acceleration: s.a, noise: 0.05 m/s^2}
  a2: {acceleration: s.b, noise: 0.05 m/s^2}
simulate: {duration: 12 s, sample_rate: 200 Hz}
estimate:
  unknown: {mount.k3: {initial: 3e6, std: 1e6}}
)" + settings;
}

/// The case's study over the record of a structure whose second mass is 4 % heavier.
StudyResults run_over_heavier(Study& study) {
  static const StudyResults truth = run_study(study_of(two_masses("1.04 kg", "")), "simulate");
  RunOptions options;
  options.simulation = [] { return truth.get<SimulationOutcome>(); };
  return run_study(study, "estimate", options);
}

TEST(FreedNumbersOfACase, AreProposedAsAnEditThatRuns) {
  Study study = study_of(two_masses("1 kg", ""));
  const auto results = run_over_heavier(study);
  ASSERT_TRUE(results.proposed);
  ASSERT_EQ(results.proposed->edits.size(), 1U);
  EXPECT_EQ(results.proposed->edits[0].substr(0, 38), "estimate.unknown.s.b.mass: {initial: 1");
  const Study edited = study_of(results.proposed->yaml);
  ASSERT_EQ(edited.problem->settings.unknowns.size(), 2U);
  EXPECT_EQ(edited.problem->settings.unknowns[1].name, "s.b.mass");
  EXPECT_EQ(study.problem->settings.unknowns.size(), 1U);
  const auto summary = summarise(study, results);
  EXPECT_EQ(summary["proposed"]["file"], "case.proposed.yaml");
  EXPECT_EQ(summary["freed"]["how"], "ask");
  EXPECT_EQ(summary["freed"]["tried"][0]["name"], "s.b.mass");
  EXPECT_FALSE(summary["freed"]["moved"].empty());
  EXPECT_NE(console_report(study, results).find("is better estimated"), std::string::npos);
}

TEST(FreedNumbersOfACase, AreUnknownsOfTheRunThatTakesThem) {
  Study study = study_of(two_masses("1 kg", "  free: auto\n"));
  const auto results = run_over_heavier(study);
  const auto& outcome = results.get<EstimationOutcome>();
  ASSERT_TRUE(outcome.freed && outcome.freed->taken);
  EXPECT_FALSE(results.proposed);
  ASSERT_EQ(study.problem->settings.unknowns.size(), 2U);
  const auto last = outcome.result.unknowns.mean.cols() - 1;
  const double mass = outcome.result.unknowns.mean(1, last), std = outcome.result.unknowns.deviation(1, last);
  EXPECT_NEAR(mass, 1.04, 3.5 * std);
  EXPECT_NEAR(outcome.result.unknowns.mean(0, last), 4e6, 3.5 * outcome.result.unknowns.deviation(0, last));
  const auto summary = summarise(study, results);
  EXPECT_EQ(summary["verdict"]["state"], "consistent");
  EXPECT_TRUE(summary["parameters"].contains("s.b.mass"));
  ASSERT_TRUE(results.identified);
  EXPECT_NE(results.identified->yaml.find("s.b.mass"), std::string::npos);
  EXPECT_NE(console_report(study, results).find("is an unknown now"), std::string::npos);
}

TEST(FreedNumbersOfACase, AreNotTriedWhereTheCaseSaysSo) {
  Study study = study_of(two_masses("1 kg", "  free: none\n"));
  const auto results = run_over_heavier(study);
  EXPECT_FALSE(results.proposed);
  EXPECT_FALSE(summarise(study, results).contains("freed"));
  EXPECT_EQ(results.verdict.reasons().front().code, "fixed_parameter");
  EXPECT_EQ(results.verdict.reasons().front().remedy.find("estimate.unknown"), std::string::npos);
}

}  // namespace
}  // namespace kalfem::test
