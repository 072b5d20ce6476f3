// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>

#include "kalfem/base/random.hpp"
#include "kalfem/steps/inference/outcome.hpp"

namespace kalfem {

/// Four chains of four parameters: a stiff one that is well known, two that depend on each other along a curve, and a
/// damping of which the data tell little.
inline SampleSet sample_draws(Eigen::Index chains = 4, Eigen::Index draws = 300) {
  SampleSet set{.names = {"suspension.k", "suspension.mu_k1", "suspension.mu_k2", "body.damping"}};
  set.chains = chains;
  set.draws = draws;
  const Eigen::Index count = chains * draws;
  set.values.resize(4, count);
  set.log_likelihood.resize(count);
  set.log_prior.resize(count);
  RandomStream random(5, "draws");
  for (Eigen::Index k = 0; k < count; ++k) {
    const double a = random.normal(), b = random.normal(), c = random.normal(), d = random.normal();
    set.values.col(k) << 2.1e5 + 900.0 * a, 20.0 + 0.8 * b, 2e-3 * (1.0 + 0.2 * b + 0.08 * b * b + 0.05 * c + 0.05 * a),
        std::abs(0.02 + 0.009 * d);
    set.log_likelihood[k] = 8421.0 - 0.5 * (a * a + b * b + c * c);
    set.log_prior[k] = -3.0 - 0.5 * d * d;
  }
  return set;
}

inline ParameterSummary normal_summary(const std::string& name, double mean, double deviation) {
  return {name,
          mean,
          deviation,
          mean - 1.96 * deviation,
          mean - deviation,
          mean,
          mean + deviation,
          mean + 1.96 * deviation};
}

inline RankedLaw sample_law(const std::string& name, double log_evidence, double probability,
                            const std::string& words) {
  RankedLaw law{.name = name, .law = name, .parameters = 3};
  law.log_evidence = log_evidence;
  law.log_evidence_deviation = 0.07;
  law.log_likelihood = log_evidence + 14.2;
  law.occam = -14.2;
  law.probability = probability;
  law.words = words;
  law.posterior = {normal_summary("suspension.k", 2.1e5, 900.0)};
  law.units = {"N/m"};
  law.validation = 3.21;
  law.validation_one_step = 0.043;
  return law;
}

/// Everything that an inference can find.
inline InferenceOutcome sample_inference() {
  InferenceOutcome outcome;
  outcome.likelihood = "the filter's innovations";
  outcome.method = "four adaptive Markov chains";
  outcome.samples = sample_draws();
  outcome.units = {"N/m", "N", "m", "-"};
  outcome.truths = {2.105e5, 20.4, 2e-3, std::nullopt};
  outcome.prior = {normal_summary("suspension.k", 2e5, 4e4), normal_summary("suspension.mu_k1", 15.0, 5.0),
                   normal_summary("suspension.mu_k2", 2.5e-3, 1e-3), normal_summary("body.damping", 0.02, 0.01)};
  outcome.prior_marginals = {NormalPrior{2e5, 4e4}, NormalPrior{15.0, 5.0}, LogNormalPrior{2.3e-3, 0.4},
                             NormalPrior{0.02, 0.01, 0.0}};
  outcome.posterior = summarise_samples(outcome.samples);
  outcome.correlation = posterior_correlation(outcome.samples);
  outcome.most_probable = Eigen::Vector4d(2.1e5, 20.0, 2e-3, 0.02);
  outcome.log_likelihood = 8421.0;
  outcome.log_evidence = 8399.4;
  outcome.log_evidence_deviation = 0.06;
  outcome.convergence.assign(4, {1.002, 1100.0, 900.0});
  outcome.evaluations = 1640;
  std::vector<InformedParameter> informed;
  for (std::size_t i = 0; i < 4; ++i)
    informed.push_back({outcome.posterior[i].name, outcome.posterior[i].mean, outcome.prior[i].deviation});
  const Eigen::Vector4d deviation(950.0, 0.8, 6e-4, 0.02);
  const Eigen::MatrixXd information = deviation.cwiseAbs2().cwiseInverse().asDiagonal();
  outcome.before = identifiability(2.0 * information, informed);
  outcome.after = identifiability(information, informed);
  outcome.beside_filter = {{"suspension.k", 2.1002e5, 910.0, -0.02, 1.01},
                           {"suspension.mu_k2", 1.9e-3, 3e-4, 0.6, 0.55}};
  ProfileLikelihood profile;
  profile.name = "suspension.mu_k1";
  profile.unit = "N";
  profile.values = Eigen::VectorXd::LinSpaced(21, 16.8, 23.2);
  profile.log_likelihood = -0.5 * ((profile.values.array() - 20.0) / 0.8).square();
  profile.lower = 18.43;
  profile.upper = 21.57;
  outcome.profiles = {profile};
  PredictiveBand band{.sensor = "a3", .unit = "m/s^2", .start = 1.0, .sample_rate = 200.0};
  band.mean.resize(800);
  for (Eigen::Index k = 0; k < 800; ++k) band.mean[k] = std::sin(0.05 * static_cast<double>(k)) * std::exp(-0.002 * k);
  band.lower = band.mean.array() - 0.2;
  band.upper = band.mean.array() + 0.2;
  band.measured = band.mean;
  for (Eigen::Index k = 0; k < 800; k += 3) band.measured[k] += 0.1 * std::cos(static_cast<double>(k * k));
  band.measured[100] = std::nan("");
  band.coverage = 0.953;
  outcome.bands = {band};
  RankedLaw failed{.name = "cubic", .law = "cubic"};
  failed.failure = "no sample of the prior has a likelihood";
  outcome.laws = LawRanking{
      "suspension",
      {sample_law("saturating", 8399.4, 0.9990, ""), sample_law("linear", 8392.5, 0.0010, "very strong"), failed}};
  OutputSensitivity sensitivity{.output = "frequency.1", .unit = "Hz"};
  sensitivity.indices.first = {{0.81, 0.77, 0.85}, {0.02, -0.01, 0.05}, {0.1, 0.05, 0.15}, {0.0, -0.02, 0.02}};
  sensitivity.indices.total = {{0.86, 0.8, 0.9}, {0.04, 0.02, 0.06}, {0.13, 0.1, 0.16}, {0.0, 0.0, 0.01}};
  outcome.sensitivity = {sensitivity};
  outcome.warnings = {"the record is short: 800 samples"};
  outcome.seconds = 12.3;
  return outcome;
}

}  // namespace kalfem
