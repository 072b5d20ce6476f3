// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "casefile/case_run.hpp"
#include "kalfem/steps/inference/outcome.hpp"
#include "kalfem/steps/inference/report.hpp"
#include "kalfem/steps/study_results.hpp"

namespace kalfem::test {
namespace {

/// Two masses of 10 kg and their frequencies: 30, 40 kN/m and 80, 15 kN/m fit alike.
const std::string two_masses = R"(kalfem: 1
substructures:
  c:
    masses: {m1: 10 kg, m2: 10 kg}
    springs:
      - {name: k1, from: ground, to: m1, stiffness: 34 kN/m}
      - {name: k2, from: m1, to: m2, stiffness: 36 kN/m}
update:
  parameters: {c.k1.stiffness: {initial: 34000, bounds: [5000, 120000]}, c.k2.stiffness: {initial: 36000, bounds: [5000, 80000]}}
  compare: {m: {modes: c, frequencies: [5.5772355 Hz, 15.733013 Hz], deviation: 1 %}}
)";

InferenceOutcome inferred(const std::string& text) {
  const auto results = results_of(text, "infer");
  EXPECT_TRUE(results.has<InferenceOutcome>()) << results.failure;
  const auto* outcome = results.find<InferenceOutcome>();
  return outcome ? *outcome : InferenceOutcome{};
}

bool warns(const InferenceOutcome& outcome, const std::string& part) {
  return std::ranges::any_of(outcome.warnings, [&](const auto& each) { return each.find(part) != std::string::npos; });
}

TEST(ModesOfACase, BothOfTwoAreNamedWithTheirWeights) {
  double log_evidence = 0.0;
  for (const std::string method : {"importance", "laplace"}) {
    const auto outcome = inferred(two_masses + "infer: {samples: 1000, method: " + method + "}\n");
    ASSERT_EQ(outcome.modes.size(), 2u) << method;
    for (const auto& mode : outcome.modes) {
      EXPECT_NEAR(mode.weight, 0.5, 0.05) << method;
      const bool first = mode.peak[0] < 55e3;
      EXPECT_NEAR(mode.mean[0], first ? 30e3 : 80e3, 500.0) << method;
      EXPECT_NEAR(mode.mean[1], first ? 40e3 : 15e3, 250.0) << method;
      EXPECT_LT(mode.deviation[0], 3e3) << method;
    }
    EXPECT_GE(*outcome.prior_starts, 60) << method;
    EXPECT_TRUE(outcome.warnings.empty()) << outcome.warnings.front();
    const std::string answer = inference_answer(outcome);
    EXPECT_NE(answer.find("2 separate sets of values explain the data"), std::string::npos) << answer;
    EXPECT_EQ(answer.find("The data determine"), std::string::npos) << answer;
    EXPECT_NE(inference_method_words(outcome).find("is excluded with 95 %"), std::string::npos);
    EXPECT_EQ(inference_summary(outcome)["modes"].size(), 2u);
    if (method == "importance") log_evidence = *outcome.log_evidence;
    EXPECT_NEAR(*outcome.log_evidence, log_evidence, 0.1);
  }
  EXPECT_TRUE(warns(inferred(two_masses + "infer: {samples: 400, method: metropolis}\n"), "separate maxima"));
}

// A third spring that only one of the two sets agrees with leaves one mode.
TEST(ModesOfACase, OneIsNotTakenForSeveral) {
  const auto outcome = inferred(changed(two_masses, "bounds: [5000, 120000]", "bounds: [5000, 60000]") + "infer: {}\n");
  EXPECT_TRUE(outcome.modes.empty());
  EXPECT_TRUE(outcome.warnings.empty()) << outcome.warnings.front();
  EXPECT_NE(inference_answer(outcome).find("The data determine both parameters"), std::string::npos);
}

/// Two masses with a cubic mount; from a wide prior the filter's first seconds are far from linear.
const std::string cubic_mount = R"(kalfem: 1
substructures:
  s:
    masses: {a: 1, b: 2}
    springs: [{name: k, from: ground, to: a, stiffness: 900, damping: 2}]
connectors:
  mount: {from: s.a, to: s.b, law: cubic, parameters: {k: 500 N/m, c: 3, k3: 2e7}}
excitation:
  f: {force: s.a, random: {rms: 4 N, band: [0.5, 20 Hz], seed: 3}}
sensors:
  a: {acceleration: s.a, noise: 20 %}
  b: {acceleration: s.b, noise: 20 %}
simulate: {duration: 3 s, sample_rate: 250 Hz, seed: 1}
estimate:
  substeps: 2
  diagnose: false
  unknown:
    mount.k: {initial: 400 N/m, std: 50 %, transform: log}
    mount.k3: {initial: 1e7, std: 50 %, transform: log}
  settle: 0.5 s
)";

TEST(FilterPosterior, SaysWhereTheLikelihoodLiesElsewhere) {
  const std::string infer = "infer: {samples: 200, predictions: 0, method: filter}\n";
  std::string far = changed(cubic_mount, "rms: 4 N", "rms: 8 N");
  far = changed(far, "initial: 400 N/m, std: 50 %", "initial: 100 N/m, std: 50 %");
  far = changed(far, "initial: 1e7, std: 50 %", "initial: 3e6, std: 50 %");
  EXPECT_TRUE(warns(inferred(far + infer), "are not those that the likelihood of the record finds most probable"));
  std::string near = changed(cubic_mount, "initial: 400 N/m, std: 50 %", "initial: 490 N/m, std: 5 %");
  near = changed(near, "initial: 1e7, std: 50 %", "initial: 1.9e7, std: 20 %");
  EXPECT_FALSE(warns(inferred(near + infer), "finds most probable"));
}

TEST(SubstepBias, StandsInTheDeviationOfTheEvidence) {
  const auto one =
      inferred(changed(cubic_mount, "substeps: 2", "substeps: 1") + "infer: {samples: 200, predictions: 0}\n");
  const auto many =
      inferred(changed(cubic_mount, "substeps: 2", "substeps: 16") + "infer: {samples: 200, predictions: 0}\n");
  EXPECT_GT(std::abs(one.substep_bias), 20.0 * std::abs(many.substep_bias));
  EXPECT_GE(*one.log_evidence_deviation, std::abs(one.substep_bias));
  EXPECT_NEAR(*one.log_evidence, *many.log_evidence, 2.0 * *one.log_evidence_deviation);
}

}  // namespace
}  // namespace kalfem::test
