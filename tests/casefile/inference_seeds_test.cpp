// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <map>

#include "casefile/case_run.hpp"
#include "kalfem/base/random.hpp"
#include "kalfem/steps/inference/outcome.hpp"

// Statistics of posteriors and of choices between laws over many records.

namespace kalfem::test {
namespace {

using Eigen::VectorXd;

InferenceOutcome inferred(const std::string& text) {
  const auto results = results_of(text, "infer");
  if (!results.has<InferenceOutcome>()) throw std::runtime_error(results.failure);
  return results.get<InferenceOutcome>();
}

/// The chain of eleven degrees of freedom on a moving ground; noise in m/s^2, so that it does not know the parameters.
std::string chain(double mu_k1, double mu_c1, int seed, const std::string& record, const std::string& noise,
                  const std::string& filter) {
  return fmt::format(R"(kalfem: 1
substructures:
  wheel: {{masses: {{w: 1.5 kg}}, springs: [{{name: k_w, from: ground, to: w, stiffness: 20 kN/m}}]}}
  body: {{chain: {{masses: 10, mass: 1 kg, stiffness: 30 kN/m}}, damping: {{modal: 1 %}}}}
connectors:
  suspension: {{from: wheel.w, to: body.1, law: saturating,
    parameters: {{k: 5 kN/m, mu_k1: {} N, mu_k2: 2 mm, c: 10 N s/m, mu_c1: {} N, mu_c2: 0.05 m/s}}}}
excitation: {{road: {{base_displacement: wheel.ground, random: {{rms: 3 mm, band: [0.5, 30 Hz], seed: {}}}}}}}
sensors:
  a3: {{acceleration: body.2, noise: {}}}
  a5: {{acceleration: body.4, noise: {}}}
  a7: {{acceleration: body.6, noise: {}}}
  a11: {{acceleration: body.10, noise: {}}}
simulate: {{{}, tolerance: 1e-3, seed: {}}}
estimate:
  diagnose: false
  outliers: keep
  {}
  unknown:
    suspension.mu_k1: {{initial: 15 N, std: 6 N, transform: log}}
    suspension.mu_c1: {{initial: 10 N, std: 4 N, transform: log}}
  settle: 0.2 s
infer: {{samples: 300, predictions: 0}}
)",
                     mu_k1, mu_c1, seed, noise, noise, noise, noise, record, seed, filter);
}

// Where parameters are drawn from the prior and records from the parameters, the true value's rank in the posterior is
// uniform (Talts, Betancourt, Simpson, Vehtari and Gelman 2018). Four substeps move the estimate by less than .15 of
// its deviation.
TEST(InferenceSeeds, RanksOfTheTruthAreUniform) {
  constexpr int draws = 200, bins = 10;
  constexpr double chi_squared_99 = 21.67;  // 9 degrees of freedom
  std::array<std::array<int, bins>, 2> counts{};
  int unreliable = 0;
  RandomStream random(11, "calibration");
  for (int draw = 0; draw < draws; ++draw) {
    const std::array truth{15.0 * std::exp(0.4 * random.normal()), 10.0 * std::exp(0.4 * random.normal())};
    const auto outcome = inferred(
        chain(truth[0], truth[1], draw + 1, "duration: 1.6 s, sample_rate: 500 Hz", "10 m/s^2", "substeps: 4"));
    if (!outcome.warnings.empty()) ++unreliable;
    const VectorXd& weights = outcome.samples.weights;
    for (std::size_t i = 0; i < 2; ++i) {
      double below = 0.0;
      for (Eigen::Index k = 0; k < weights.size(); ++k)
        if (outcome.samples.values(static_cast<Eigen::Index>(i), k) < truth[i]) below += weights[k];
      ++counts[i][static_cast<std::size_t>(std::min<double>(bins - 1, std::floor(below * bins)))];
    }
  }
  for (std::size_t i = 0; i < 2; ++i) {
    double chi_squared = 0.0;
    constexpr double expected = static_cast<double>(draws) / bins;
    std::printf("%s:", i == 0 ? "mu_k1" : "mu_c1");
    for (const int count : counts[i]) {
      chi_squared += (count - expected) * (count - expected) / expected;
      std::printf(" %d", count);
    }
    std::printf("   chi-squared %.2f (99 %%: %.2f)\n", chi_squared, chi_squared_99);
    EXPECT_LT(chi_squared, chi_squared_99);
  }
  std::printf("%d of %d posteriors with a warning\n", unreliable, draws);
}

TEST(InferenceSeeds, AgreesWithTheFilterOnTheLongChain) {
  for (const int seed : {1, 2, 3}) {
    const auto outcome = inferred(chain(20.0, 10.0, seed, "duration: 20 s, sample_rate: 1 kHz", "1 m/s^2", ""));
    for (const auto& each : outcome.beside_filter) {
      std::printf("seed %d %s: mean %+.3f deviations apart, deviations' ratio %.3f\n", seed, each.name.c_str(),
                  each.mean_difference, each.deviation_ratio);
      EXPECT_TRUE(each.agrees()) << each.name;
    }
  }
}

const std::map<std::string, std::string> true_laws{
    {"linear", "law: linear, parameters: {k: 2000, c: 8}"},
    {"cubic", "law: cubic, parameters: {k: 1400, k3: 4e7, c: 8}"},
    {"saturating", "law: saturating, parameters: {k: 1000, mu_k1: 8, mu_k2: 3e-3, c: 8, mu_c1: 0, mu_c2: 1}"},
    {"bouc_wen", "law: bouc_wen, parameters: {k: 2500, alpha: 0.4, beta: 200, gamma: 100, c: 4}"}};

std::string law_case(const std::string& truth, int seed) {
  return fmt::format(R"(kalfem: 1
substructures: {{s: {{masses: {{m: 2 kg}}}}}}
connectors: {{c: {{from: s.ground, to: s.m, {}}}}}
excitation: {{f: {{force: s.m, random: {{rms: 8 N, band: [0.5, 15 Hz], seed: {}}}}}}}
sensors: {{a: {{acceleration: s.m, noise: 5 %}}}}
simulate: {{duration: 5 s, sample_rate: 200 Hz, seed: {}}}
estimate: {{substeps: 2, diagnose: false, settle: 0.2 s, unknown: {{c.k: {{initial: 2000, std: 50 %, transform: log}}}}}}
infer:
  samples: 400
  predictions: 0
  method: importance
  compare_laws:
    connector: c
    laws:
      linear: {{law: linear, priors: {{k: {{lognormal: {{median: 2000, std: 60 %}}}}, c: {{lognormal: {{median: 8, std: 80 %}}}}}}}}
      cubic:
        law: cubic
        priors: {{k: {{lognormal: {{median: 2000, std: 60 %}}}}, k3: {{normal: {{mean: 0, std: 5e7}}}}, c: {{lognormal: {{median: 8, std: 80 %}}}}}}
      saturating:
        law: saturating
        parameters: {{mu_c1: 0, mu_c2: 1}}
        priors: {{k: {{lognormal: {{median: 2000, std: 60 %}}}}, mu_k1: {{lognormal: {{median: 5, std: 100 %}}}}, mu_k2: {{lognormal: {{median: 3e-3, std: 80 %}}}}, c: {{lognormal: {{median: 8, std: 80 %}}}}}}
      bouc_wen:
        law: bouc_wen
        priors: {{k: {{lognormal: {{median: 2000, std: 60 %}}}}, alpha: {{uniform: [0.05, 1]}}, beta: {{lognormal: {{median: 200, std: 100 %}}}}, gamma: {{normal: {{mean: 0, std: 150}}}}, c: {{lognormal: {{median: 8, std: 80 %}}}}}}
)",
                     true_laws.at(truth), seed, seed);
}

TEST(InferenceSeeds, TheTrueLawIsChosen) {
  int right = 0;
  for (const auto& [truth, law] : true_laws)
    for (int seed = 1; seed <= 10; ++seed) {
      const auto outcome = inferred(law_case(truth, seed));
      const auto& ranking = outcome.laws->laws;
      right += ranking.front().name == truth;
      std::printf("%-10s seed %2d:", truth.c_str(), seed);
      for (const auto& each : ranking)
        std::printf("  %s %.2f+-%.2f%s", each.name.c_str(), each.log_evidence, each.log_evidence_deviation,
                    !each.failure.empty()   ? " FAILED"
                    : each.warnings.empty() ? ""
                                            : "!");
      std::printf("\n");
      std::fflush(stdout);
      if (truth == "linear") {
        EXPECT_EQ(ranking.front().name, truth) << "linear data choose a larger law";
      }
    }
  std::printf("the true law first in %d of 40\n", right);
  EXPECT_GE(right, 39);
}

}  // namespace
}  // namespace kalfem::test
