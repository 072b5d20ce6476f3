// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "casefile/case_run.hpp"
#include "kalfem/report/result_set.hpp"
#include "kalfem/steps/estimation/compute.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/estimation/report.hpp"
#include "kalfem/steps/study_results.hpp"
#include "kalfem/study/study.hpp"

// A case with two laws against an estimation with each law by itself, mixed here by hand.

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// A joint with a cubic part, so small that a linear law is about as likely, or so large that it is not.
std::string case_with(const std::string& cubic) {
  return R"(kalfem: 1
substructures:
  s: {masses: {a: 2 kg, b: 1 kg}, springs: [{name: k, from: ground, to: a, stiffness: 800 N/m, damping: 4 N s/m}, {name: k2, from: ground, to: b, stiffness: 20 N/m}]}
connectors: {mount: {from: s.a, to: s.b, law: cubic, parameters: {k: 500 N/m, k3: )" +
         cubic + R"(, c: 3 N s/m}}}
excitation: {f: {force: s.a, random: {rms: 4 N, band: [0.5, 20 Hz], seed: 3}}}
sensors: {a: {acceleration: s.a, noise: 10 %}}
simulate: {duration: 3 s, sample_rate: 200 Hz, seed: 2}
estimate:
  substeps: 2
  diagnose: false
  smooth: true
  settle: 0.5 s
  unknown:
    s.k.stiffness: {initial: 780 N/m, std: 40 N/m}
    mount.k: {initial: 480 N/m, std: 50 N/m}
    mount.k3: {initial: 0, std: 2e6}
  alternatives:
    connector: mount
    laws:
      straight: {law: linear, parameters: {c: 3 N s/m}, priors: {k: {normal: {mean: 480 N/m, std: 50 N/m}}}}
)";
}

double evidence(const EstimationOutcome& outcome) { return outcome.result.log_density.sum(); }

void expect_mixed(const PointQuantity& mixed, const std::vector<PointQuantity>& one, double weight,
                  const std::vector<PointQuantity>& other) {
  const auto& a = *find_quantity(one, mixed.point, mixed.quantity);
  const auto& b = *find_quantity(other, mixed.point, mixed.quantity);
  const VectorXd mean = weight * a.mean + (1.0 - weight) * b.mean;
  // of two models: w s_a^2 + (1 - w) s_b^2 + w (1 - w) (m_a - m_b)^2
  const VectorXd variance = weight * a.deviation.cwiseAbs2() + (1.0 - weight) * b.deviation.cwiseAbs2() +
                            weight * (1.0 - weight) * (a.mean - b.mean).cwiseAbs2();
  EXPECT_LT((mixed.mean - mean).norm(), 1e-12 * mean.norm()) << mixed.point;
  EXPECT_LT((mixed.deviation - variance.cwiseSqrt()).norm(), 1e-12 * variance.cwiseSqrt().norm()) << mixed.point;
}

TEST(LawAlternatives, AreMixedByTheirEvidence) {
  const std::string text = changed(case_with("5e4 N/m^3"), "std: 2e6", "std: 1e5");
  const Study study = study_of(text);
  const auto results = results_of(text, "estimate");
  const auto& found = results.get<EstimationOutcome>();
  ASSERT_EQ(found.alternatives.size(), 1u);

  const auto by_itself = [&](const Study& of) {
    AugmentedModelSetup setup = *of.augmented_model;
    return run_estimation(of, setup, results, {}, {}, {});
  };
  const auto cubic = by_itself(study), straight = by_itself(*study.alternatives[0].study);
  const double weight = 1.0 / (1.0 + std::exp(evidence(straight) - evidence(cubic)));
  EXPECT_GT(weight, 0.01);  // both matter
  EXPECT_LT(weight, 0.99);
  EXPECT_NEAR(found.weight, weight, 1e-9);
  EXPECT_NEAR(found.alternatives[0]->weight, 1.0 - weight, 1e-9);
  ASSERT_EQ(found.points.size(), cubic.points.size());
  for (const auto& each : found.points) expect_mixed(each, cubic.points, weight, straight.points);
  for (const auto& each : found.smoothed_points)
    expect_mixed(each, cubic.smoothed_points, weight, straight.smoothed_points);
  EXPECT_EQ(unlikely_law_words(study, found), "");
  const auto told = summarise(study, results)["estimation"];
  EXPECT_NEAR(told["weight"].get<double>(), weight, 1e-9);
  EXPECT_NEAR(told["alternatives"]["straight"]["weight"].get<double>(), 1.0 - weight, 1e-9);
  EXPECT_TRUE(told["alternatives"]["straight"]["parameters"].contains("mount.k"));
}

// Where the record is far from linear, the other law has no weight, and the answer is that of the case.
TEST(LawAlternatives, WithoutEvidenceChangeNothing) {
  const std::string text = case_with("5e7 N/m^3");
  const Study study = study_of(text);
  const auto results = results_of(text, "estimate");
  const auto& found = results.get<EstimationOutcome>();
  AugmentedModelSetup setup = *study.augmented_model;
  const auto alone = run_estimation(study, setup, results, {}, {}, {});
  EXPECT_GT(found.weight, 1.0 - 1e-9);
  for (std::size_t i = 0; i < found.points.size(); ++i)
    EXPECT_LT((found.points[i].mean - alone.points[i].mean).norm(), 1e-9 * alone.points[i].mean.norm());
}

TEST(LawAlternatives, FarBetterThanTheLawOfTheCaseAreTold) {
  std::string text =
      changed(case_with("5e7 N/m^3"), "mount.k3: {initial: 0, std: 2e6}", "mount.k3: {initial: 0, std: 1}");
  text = changed(text, "laws:",
                 "laws:\n      bent: {law: cubic, parameters: {c: 3 N s/m}, priors: {k: {normal: {mean: 480 N/m, "
                 "std: 50 N/m}}, k3: {lognormal: {median: 4e7, std: 40 %}}}}");
  const auto results = results_of(text, "estimate");
  EXPECT_LT(results.get<EstimationOutcome>().weight, 1e-6);
  EXPECT_TRUE(std::ranges::any_of(results.warnings, [](const std::string& each) {
    return each.find("give it the law 'bent'") != std::string::npos;
  }));
}

TEST(LawAlternatives, ThatCannotBeEstimatedAreRefused) {
  const auto refused = [](const std::string& from, const std::string& to, const std::string& why) {
    const auto problems = problems_of(changed(case_with("1e6"), from, to));
    EXPECT_NE(problems.find(why), std::string::npos) << problems;
  };
  refused("connector: mount", "connector: mout", "did you mean 'mount'");
  refused("priors: {k: {normal: {mean: 480 N/m, std: 50 N/m}}}", "priors: {k: {uniform: [100, 900]}}",
          "no bounded priors");
  refused("priors: {k: {normal: {mean: 480 N/m, std: 50 N/m}}}", "priors: {}", "no unknown parameter");
  refused("law: linear", "law: liner", "with the law 'straight'");
  refused("mount.k: {initial: 480 N/m, std: 50 N/m}",
          "both: {initial: 480 N/m, std: 50 N/m, applies_to: [mount.k, s.k2.stiffness]}",
          "applies to 'mount' and to others");
}

}  // namespace
}  // namespace kalfem::test
