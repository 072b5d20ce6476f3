// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/information/identifiability.hpp"
#include "kalfem/sampling/convergence.hpp"
#include "kalfem/sampling/marginal_prior.hpp"
#include "kalfem/sampling/posterior.hpp"
#include "kalfem/sampling/posterior_mode.hpp"
#include "kalfem/sampling/profile_likelihood.hpp"
#include "kalfem/sampling/sobol.hpp"

namespace kalfem {

/// The profile likelihood of one parameter.
struct ProfileLikelihood : Profile {
  std::string name, unit;
};

/// Response of the structure at draws of the posterior beside what a sensor measured, sample by sample.
struct PredictiveBand {
  std::string sensor, unit;
  double start = 0.0, sample_rate = 0.0;  ///< [s], [Hz]
  Eigen::VectorXd measured;               ///< NaN where missing
  Eigen::VectorXd lower, mean, upper;     ///< of the draws; 95 % about it with the sensor's noise
  double coverage = 0.0;                  ///< share of the measured samples inside
};

/// One law of a comparison.
struct RankedLaw {
  std::string name, law;
  Eigen::Index parameters = 0;          ///< unknown ones
  double log_evidence = 0.0;            ///< ln Z
  double log_evidence_deviation = 0.0;  ///< standard error of the samples
  double log_likelihood = 0.0;          ///< the largest one found
  double occam = 0.0;                   ///< ln Z less the largest ln p(data | parameters): what its freedom costs
  double probability = 0.0;             ///< P(law | data) with equal prior probabilities
  std::string words;                    ///< the best law against this one, after Kass and Raftery; empty for the best
  std::vector<ParameterSummary> prior, posterior;
  Eigen::VectorXd most_probable;               ///< values of its parameters
  std::vector<std::string> units;              ///< of its parameters
  std::optional<double> validation;            ///< mean ln p of a sample of the validation part, given the posterior
  std::optional<double> validation_one_step;   ///< NRMSE of the prediction one sample ahead there
  std::optional<double> validation_open_loop;  ///< NRMSE of the simulation there
  std::vector<std::string> warnings;
  std::string failure;  ///< why it has no evidence
};

/// Laws for one connector, the most probable first.
struct LawRanking {
  std::string connector;  ///< its name, or the names of several
  std::vector<RankedLaw> laws;
};

/// Beside a posterior: the normal distribution that the filter ends with.
struct FilterComparison {
  std::string name;
  double filter_mean = 0.0, filter_deviation = 0.0;
  double mean_difference = 0.0;  ///< posterior's mean less the filter's, in posterior deviations
  double deviation_ratio = 1.0;  ///< the filter's deviation over the posterior's
  [[nodiscard]] bool agrees() const {
    return std::abs(mean_difference) <= 0.3 && deviation_ratio >= 1.0 / 1.15 && deviation_ratio <= 1.15;
  }
};

/// Sobol' indices of one output.
struct OutputSensitivity {
  std::string output, unit;
  SobolIndices indices;
};

/// What the data tell of the parameters. Lists are by parameter unless they say otherwise.
struct InferenceResult {
  std::string likelihood, method;  ///< in words
  SampleSet samples;               ///< of the posterior; weighted after importance sampling
  std::vector<std::string> units;
  std::vector<std::optional<double>> truths;
  std::vector<ParameterSummary> prior, posterior;
  std::vector<MarginalPrior> prior_marginals;  ///< their shapes, for pictures; empty: none is drawn
  Eigen::MatrixXd correlation;
  Eigen::VectorXd most_probable;  ///< values of the largest p(data | theta) p(theta) found
  double log_likelihood = 0.0;    ///< there
  std::optional<double> log_evidence, log_evidence_deviation;
  double substep_bias = 0.0;                ///< of ln Z, from the likelihood with twice the substeps; in its deviation
  std::vector<PosteriorMode> modes;         ///< two or more where the posterior has several, the heaviest first
  std::optional<int> prior_starts;          ///< searches for maxima from samples of the prior; empty: no such method
  std::vector<Convergence> convergence;     ///< of Markov chains
  std::optional<double> effective_samples;  ///< of weighted samples
  std::optional<double> pareto_k;           ///< of their weights; above 0.7 they do not hold
  double acceptance = 0.0;                  ///< of moves, 0 without
  long long evaluations = 0;                ///< of the likelihood
  long long evaluations_before = 0;         ///< of these, and of those of laws and profiles, in an earlier run
  std::optional<Identifiability> before;    ///< by the Fisher information of the expected record at the prior's centre
  std::optional<Identifiability> after;     ///< by that of the record at the posterior's mean
  std::vector<FilterComparison> beside_filter;
  std::vector<ProfileLikelihood> profiles;
  std::vector<PredictiveBand> bands;  ///< one a sensor, where the excitation is known
  std::optional<LawRanking> laws;
  std::vector<OutputSensitivity> sensitivity;  ///< one an output
  std::vector<std::string> warnings;           ///< why the posterior may not hold, in words
  double seconds = 0.0;

  /// Where one point stands for the posterior: its mean, or that of the heaviest of several modes, between which no
  /// values fit.
  [[nodiscard]] Eigen::VectorXd centre() const;
};

}  // namespace kalfem
