// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>

#include "casefile/case_run.hpp"
#include "kalfem/steps/inference/compute.hpp"
#include "kalfem/steps/inference/outcome.hpp"

// What the data tell of the unknowns of a case: posterior, profile, bands, identifiability, sensitivity.

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Two masses on a spring and a hardening mount under a random force.
const std::string two_masses = R"(kalfem: 1
substructures:
  s:
    masses: {a: 2 kg, b: 1 kg}
    springs: [{name: k, from: ground, to: a, stiffness: 800 N/m, damping: 4 N s/m}]
connectors:
  mount: {from: s.a, to: s.b, law: cubic, parameters: {k: 500 N/m, k3: 2e7, c: 3 N s/m}}
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

std::string with_infer(const std::string& keys) { return two_masses + "infer: {" + keys + "}\n"; }

InferenceOutcome inferred(const std::string& text) {
  const auto results = results_of(text, "infer");
  EXPECT_TRUE(results.has<InferenceOutcome>()) << results.failure;
  const auto* outcome = results.find<InferenceOutcome>();
  return outcome ? *outcome : InferenceOutcome{};
}

void expect_near_filter(const InferenceOutcome& outcome) {
  ASSERT_EQ(outcome.beside_filter.size(), 2u);
  for (const auto& each : outcome.beside_filter)
    EXPECT_TRUE(each.agrees()) << each.name << ": " << each.mean_difference << " deviations, ratio "
                               << each.deviation_ratio;
}

TEST(InferenceOfACase, AgreesWithTheFilterOnALongRecord) {
  // from a wide prior the filter's first seconds are far from linear, and leave it up to 1.5 deviations off
  std::string near = with_infer("samples: 400, predictions: 20, profile: [mount.k, mount.k3]");
  near = changed(near, "initial: 400 N/m, std: 50 %", "initial: 490 N/m, std: 5 %");
  near = changed(near, "initial: 1e7, std: 50 %", "initial: 1.9e7, std: 20 %");
  const auto outcome = inferred(near);
  expect_near_filter(outcome);
  EXPECT_TRUE(outcome.warnings.empty()) << outcome.warnings.front();
  EXPECT_LT(*outcome.pareto_k, 0.7);
  for (std::size_t i = 0; i < 2; ++i) {
    const auto& posterior = outcome.posterior[i];
    EXPECT_LT(std::abs(posterior.mean - *outcome.truths[i]), 4.0 * posterior.deviation) << posterior.name;
    EXPECT_LT(posterior.deviation, 0.5 * outcome.prior[i].deviation);
    // of a normal likelihood the profile's interval is 1.96 deviations each way; the prior hardly matters
    const auto& profile = outcome.profiles[i];
    ASSERT_TRUE(profile.lower && profile.upper);
    EXPECT_NEAR((*profile.upper - *profile.lower) / (2.0 * 1.96 * posterior.deviation), 1.0, 0.15);
  }
  // the bound before the record, after it, and the posterior
  for (Index i = 0; i < 2; ++i) {
    const double deviation = outcome.posterior[static_cast<std::size_t>(i)].deviation;
    EXPECT_NEAR(outcome.after->posterior_deviation[i] / deviation, 1.0, 0.15);
    EXPECT_GT(outcome.before->cramer_rao[i], 0.0);
  }
  ASSERT_EQ(outcome.bands.size(), 2u);
  for (const auto& band : outcome.bands) {
    EXPECT_GT(band.coverage, 0.90) << band.sensor;
    EXPECT_LT(band.coverage, 0.99) << band.sensor;
  }
}

TEST(InferenceOfACase, MethodsAgree) {
  const auto importance = inferred(with_infer("samples: 400, predictions: 0"));
  for (const std::string method : {"laplace", "tempered", "metropolis"}) {
    const std::string samples = method == "tempered" ? "200" : "400";
    const auto other = inferred(with_infer("samples: " + samples + ", predictions: 0, method: " + method));
    for (std::size_t i = 0; i < 2; ++i) {
      const auto &one = importance.posterior[i], &two = other.posterior[i];
      EXPECT_NEAR((two.mean - one.mean) / one.deviation, 0.0, 0.35) << method << " " << one.name;
      EXPECT_NEAR(two.deviation / one.deviation, 1.0, 0.25) << method << " " << one.name;
    }
    if (method != "metropolis") {
      // Two hundred tempered samples know it to about 0.3.
      EXPECT_NEAR(*other.log_evidence, *importance.log_evidence, method == "tempered" ? 0.9 : 0.4) << method;
    }
  }
}

/// Of an unknown that enters a linear structure linearly the filter's posterior and evidence are exact.
TEST(InferenceOfACase, ByTheFilterAnUnknownForceIsTheSameAsBySampling) {
  const auto of = [](const std::string& method) {
    return inferred(R"(kalfem: 1
substructures: {s: {masses: {m: 2 kg}, springs: [{name: k, from: ground, to: m, stiffness: 800 N/m, damping: 8}]}}
connectors: {load: {from: s.ground, to: s.m, law: preload, parameters: {f0: 1 N}}}
excitation: {f: {force: s.m, random: {rms: 10 N, band: [0.5, 10 Hz]}}}
sensors: {d: {displacement: s.m, noise: 20 %}}
simulate: {duration: 2 s, sample_rate: 100 Hz}
estimate:
  substeps: 2
  diagnose: false
  outliers: keep
  unknown: {load.f0: {initial: 0 N, std: 3 N}}
  settle: 0.1 s
infer: {samples: 4000, predictions: 0, method: )" +
                    method + "}\n");
  };
  const auto filter = of("filter"), sampled = of("importance");
  EXPECT_NEAR(*filter.log_evidence, *sampled.log_evidence, 0.02);
  EXPECT_NEAR(filter.most_probable[0], sampled.most_probable[0], 1e-3 * sampled.posterior[0].deviation);
  EXPECT_NEAR((filter.posterior[0].mean - sampled.posterior[0].mean) / sampled.posterior[0].deviation, 0.0, 0.06);
  EXPECT_NEAR(filter.posterior[0].deviation / sampled.posterior[0].deviation, 1.0, 0.05);
}

/// The data are of a cubic mount: the filter's evidence of that law is near the sampled one; that of the linear law,
/// whose filter never fits, may be off by a thousand and says so. The order is the same.
TEST(InferenceOfACase, LawsRankTheSameByTheFilterAndBySampling) {
  const auto of = [](const std::string& method) {
    return *inferred(with_infer("samples: 400, predictions: 0, method: " + method + R"(,
  compare_laws: {connector: mount, laws: {
    linear: {law: linear, parameters: {c: 3}, priors: {k: {lognormal: {median: 500, std: 20 %}}}},
    cubic: {law: cubic, parameters: {c: 3},
            priors: {k: {lognormal: {median: 500, std: 20 %}}, k3: {normal: {mean: 1e7, std: 1e7}}}}}})"))
                .laws;
  };
  const auto by_filter = of("filter").laws, sampled = of("importance").laws;
  EXPECT_EQ(sampled[0].name, "cubic");
  EXPECT_EQ(by_filter[0].name, "cubic");
  EXPECT_NEAR(by_filter[0].log_evidence, sampled[0].log_evidence, 1.0);
  EXPECT_TRUE(by_filter[0].warnings.empty());
  ASSERT_EQ(by_filter[1].warnings.size(), 2u);
  EXPECT_NE(by_filter[1].warnings[0].find("finds most probable"), std::string::npos);
  EXPECT_NE(by_filter[1].warnings[1].find("smaller differences between laws say nothing"), std::string::npos);
}

TEST(InferenceOfACase, BySimulationKnowsAsMuchAsTheFilterWithoutProcessNoise) {
  const auto filter = inferred(with_infer("samples: 300, predictions: 0"));
  const auto simulation = inferred(with_infer("samples: 300, predictions: 0, likelihood: simulation"));
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR((simulation.posterior[i].mean - filter.posterior[i].mean) / filter.posterior[i].deviation, 0.0, 0.6);
    EXPECT_NEAR(simulation.posterior[i].deviation / filter.posterior[i].deviation, 1.0, 0.25);
  }
}

/// Correlated errors are worth fewer samples.
TEST(InferenceOfACase, CorrelatedErrorsWidenThePosterior) {
  const auto white = inferred(with_infer("samples: 300, predictions: 0, likelihood: simulation"));
  const auto correlated =
      inferred(with_infer("samples: 300, predictions: 0, likelihood: simulation, correlation_time: 20 ms"));
  EXPECT_GT(correlated.posterior[0].deviation, 1.3 * white.posterior[0].deviation);
}

/// One natural frequency of one mass: f = sqrt(k / m) / (2 pi), so ln k is normal about ln(m (2 pi f)^2) in the limit
/// of a wide prior, with twice the frequency's relative deviation.
TEST(InferenceOfACase, OfAMeasuredFrequencyIsTheClosedForm) {
  const auto outcome = inferred(R"(kalfem: 1
substructures: {s: {masses: {m: 2 kg}, springs: [{name: k, from: ground, to: m, stiffness: 800 N/m}]}}
update:
  parameters: {s.k.stiffness: {initial: 800 N/m, bounds: [100 N/m, 3 kN/m]}}
  compare: {f: {modes: s, frequencies: [3.0 Hz], deviation: 1 %}}
infer: {samples: 2000}
)");
  const double k = 2.0 * std::pow(2.0 * std::numbers::pi * 3.0, 2);
  EXPECT_NEAR(outcome.posterior.at(0).mean, k, 0.05 * 0.02 * k + 0.001 * k);
  EXPECT_NEAR(outcome.posterior[0].deviation, 0.02 * k, 0.06 * 0.02 * k);
  EXPECT_TRUE(outcome.after->combinations.at(0).determined);
  // Z = integral of N(r; 0, 1) dk / 2900: dk = 2 k sigma dr
  EXPECT_NEAR(*outcome.log_evidence, std::log(0.02 * k / 2900.0), 0.05);
}

TEST(InferenceOfACase, ShareOfEachUnknownInAFrequencyIsTheClosedForm) {
  // the frequency of one mass on a spring and a connector, ln f = ln(k1 + k2) / 2 + ..., is nearly linear over 10 %
  const auto outcome = inferred(R"(kalfem: 1
substructures: {s: {masses: {m: 2 kg}, springs: [{name: k, from: ground, to: m, stiffness: 600 N/m, damping: 2}]}}
connectors: {c: {from: s.ground, to: s.m, law: linear, parameters: {k: 200 N/m}}}
excitation: {f: {force: s.m, random: {rms: 10 N, band: [0.5, 10 Hz]}}}
sensors: {a: {acceleration: s.m, noise: 5 %}}
simulate: {duration: 1 s, sample_rate: 100 Hz}
estimate:
  substeps: 1
  diagnose: false
  unknown: {s.k.stiffness: {initial: 600 N/m, std: 5 %}, c.k: {initial: 200 N/m, std: 5 %}}
  settle: 0.1 s
infer: {samples: 50, predictions: 0, method: laplace, sensitivity: {outputs: [frequency.1, force.c, nis], samples: 128}}
)");
  ASSERT_EQ(outcome.sensitivity.size(), 3u);
  const auto& frequency = outcome.sensitivity[0].indices;
  EXPECT_NEAR(frequency.first[0].value, 0.9, 0.02);  // 30^2 / (30^2 + 10^2)
  EXPECT_NEAR(frequency.total[1].value, 0.1, 0.02);
  EXPECT_NEAR(frequency.mean, std::sqrt(800.0 / 2.0) / (2.0 * std::numbers::pi), 0.02);
  EXPECT_GT(outcome.sensitivity[1].indices.mean, 0.0);
  EXPECT_GT(outcome.sensitivity[2].indices.mean, 0.0);
}

TEST(InferenceOfACase, SaysBeforeTheRunWhatTheRecordCannotTell) {
  const auto study = study_of(R"(kalfem: 1
substructures:
  tower:
    masses: {1: 2 kg, 2: 1.5 kg}
    springs:
      - {name: s1, from: ground, to: 1, stiffness: 900 N/m, damping: 2}
      - {name: s2, from: 1, to: 2, stiffness: 700 N/m, damping: 2}
excitation: {g: {base_displacement: tower.ground, random: {rms: 5 mm, band: [0.5, 10 Hz]}}}
sensors: {a1: {acceleration: tower.1, noise: 5 %}, a2: {acceleration: tower.2, noise: 5 %}}
simulate: {duration: 4 s, sample_rate: 100 Hz}
estimate:
  substeps: 2
  diagnose: false
  unknown:
    tower.1.mass: {initial: 2, std: 30 %}
    tower.2.mass: {initial: 1.5, std: 30 %}
    tower.s1.stiffness: {initial: 900, std: 30 %}
    tower.s2.stiffness: {initial: 700, std: 30 %}
    tower.s1.damping: {initial: 2, std: 30 %}
    tower.s2.damping: {initial: 2, std: 30 %}
infer: {}
)");
  const auto found = identifiability_before(study);
  ASSERT_TRUE(found.has_value());
  EXPECT_NE(found->text.find("ratios"), std::string::npos) << found->text;
  EXPECT_FALSE(found->combinations.back().determined);
}

TEST(InferenceOfACase, RefusesWhatCannotBe) {
  const auto refusal = [](const std::string& keys) { return problems_of(with_infer(keys)); };
  const auto has = [](const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  has(refusal("priors: {mount.k: {uniform: [600, 900]}}"), "excludes the initial value 400");
  has(refusal("priors: {mount.q: {uniform: [600, 900]}}"), "did you mean 'mount.k'");
  has(refusal("priors: {mount.k: {uniform: [900, 600]}}"), "not below");
  has(refusal("priors: {mount.k: {normal: {mean: 400 kg, std: 10 %}}}"), "kg");
  has(refusal("priors: {mount.k: {normal: {mean: 400, std: 0}}}"), "is 0");
  has(refusal("correlations: [{between: [mount.k, mount.k], value: 0.5}]"), "named twice");
  has(refusal("profile: mount.x"), "there is no parameter 'mount.x'");
  has(refusal("method: filter, priors: {mount.k: {normal: {mean: 400, std: 20}}}"), "priors of estimate.unknown");
  has(refusal("method: filter, correlations: [{between: [mount.k, mount.k3], value: 0.5}]"), "independent priors");
  has(refusal("method: filter, likelihood: simulation"), "another likelihood");
  has(refusal("method: filter, compare_laws: {connector: mount, laws: {one: {law: linear, priors: {k: {uniform: [1, "
              "2000]}}}, two: {law: linear, priors: {c: {normal: {mean: 3, std: 1}}}}}}"),
      "no bounded priors");
  has(refusal("likelihood: comparisons"), "nor `update`");
  has(refusal("sensitivity: {outputs: frequency.3}"), "frequency.1 to frequency.2");
  has(refusal("sensitivity: {outputs: force.q}"), "there is no output");
  has(refusal("compare_laws: {connector: mout, laws: {a: {law: linear, priors: {k: {uniform: [1, 9]}}}}}"),
      "did you mean 'mount'");
  has(refusal("compare_laws: {connector: mount, laws: {a: {law: linear, priors: {q: {uniform: [1, 9]}}}, "
              "b: {law: liner, priors: {k: {uniform: [1, 9]}}}}}"),
      "with the law 'a'");
  // an improper prior: an updated parameter without bounds has none
  has(problems_of(R"(kalfem: 1
substructures: {s: {masses: {m: 2 kg}, springs: [{name: k, from: ground, to: m, stiffness: 800 N/m}]}}
update: {parameters: {s.k.stiffness: {}}, compare: {f: {modes: s, frequencies: [3.0 Hz]}}}
infer: {}
)"),
      "improper");
  // several at once, each with its line
  const std::string two = refusal("priors: {mount.k: {uniform: [600, 900]}, mount.k3: {uniform: [1, 2]}}, profile: z");
  has(two, "mount.k:");
  has(two, "mount.k3:");
  has(two, "'z'");
}

}  // namespace
}  // namespace kalfem::test
