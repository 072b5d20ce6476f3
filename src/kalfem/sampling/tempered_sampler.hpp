// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <functional>
#include <vector>

#include "kalfem/sampling/posterior.hpp"

namespace kalfem {

/// Default values reach the figures of docs/sampling.md.
struct TemperedOptions {
  int samples = 2000;             ///< N, of every stage
  double weight_variation = 1.0;  ///< coefficient of variation of the weights that fixes the next exponent
  /// A sample that was resampled n times starts chains of at most so many samples. 1: n chains of one sample each,
  /// which is BASIS and without the bias of TMCMC's chains; large: the chains of TMCMC.
  int max_chain_length = 1;
  double acceptance = 0.25;  ///< rate that the scale of the random walk is adapted to
  int min_moves = 3;         ///< Metropolis moves between a sample and its successor, at least
  int max_moves = 200;       ///< and at most
  double correlation = 0.1;  ///< moves end where samples and their ancestors are correlated by less
  int max_stages = 1000;     ///< `finished` stays false beyond
  std::uint64_t seed = 1;
  int threads = 1;  ///< results do not depend on it
};

IssueList validate(const TemperedOptions& options);

/// For a likelihood that takes milliseconds: a tenth of the evaluations of the defaults, with a standard error of ln Z
/// of 0.1 to 0.25 for two to ten parameters. Samples keep a correlation of 0.45 with their ancestors, which the
/// standard error counts. Figures: docs/sampling.md.
TemperedOptions tempered_options_for_expensive_likelihoods(int samples = 500);

/// One finished stage.
struct TemperedStage {
  double exponent = 0.0;      ///< after it
  double log_evidence = 0.0;  ///< ln of the mean weight, its part of ln Z
  double log_evidence_variance = 0.0;
  double acceptance = 0.0;   ///< over all its moves
  double correlation = 0.0;  ///< left with the ancestors after the last move
  int moves = 0;             ///< for each sample
};

/// All that a stage starts from: stored and continued, a run gives the same bits as one that was not stopped.
struct TemperedState {
  double exponent = 0.0;           ///< beta of p(data | theta)^beta p(theta), from which the samples are
  Eigen::MatrixXd z;               ///< samples as standard normals of the prior, p x N
  Eigen::VectorXd log_likelihood;  ///< of each, N
  Eigen::VectorXi ancestor;        ///< number of the sample of the stage before that each descends from, N
  Eigen::VectorXi origin;          ///< number of the prior's sample that each descends from, N
  double lineage_variance = 0.0;   ///< Var(Z) / Z^2 by the lineages' weights
  double scale = 0.0;              ///< of the random walk, in deviations of the samples
  long long evaluations = 0;       ///< of the likelihood
  std::vector<TemperedStage> stages;

  [[nodiscard]] bool finished() const { return exponent >= 1.0; }
  [[nodiscard]] double log_evidence() const;  ///< up to `exponent`
  /// Its standard error: the larger one of two, by the weights of each stage and by all lineages since the prior (Lee
  /// and Whiteley 2018, Biometrika 105, 609-625), which sees modes whose shares no move corrects.
  [[nodiscard]] double log_evidence_deviation() const;
};

/// Called after the prior's samples and after every stage with what has been reached (stage, exponent, evaluations),
/// to show or to store it.
using TemperedProgress = std::function<void(const TemperedState&)>;

struct TemperedResult {
  SampleSet samples;                    ///< of the posterior, equal weights
  double log_evidence = 0.0;            ///< ln Z
  double log_evidence_deviation = 0.0;  ///< standard error
  TemperedState state;
  bool finished = false;  ///< false: max_stages were not enough, the samples are from an earlier stage
};

/// Samples of the prior, exponent 0. Throws InvalidInput where no sample has a likelihood.
TemperedState begin_tempering(const Posterior& posterior, const TemperedOptions& options);

/// One stage: the next exponent from the coefficient of variation of the weights w_i = L_i^(beta' - beta), ln S = ln
/// mean w, resampling, and Metropolis moves. Interrupted leaves `state` as it was.
void advance(const Posterior& posterior, const TemperedOptions& options, TemperedState& state);

/// Transitional Markov chain Monte Carlo (Ching and Chen 2007, J. Eng. Mech. 133, 816-832) in its unbiased form BASIS
/// (Wu, Angelikopoulos, Papadimitriou and Koumoutsakos 2018, ASCE-ASME J. Risk Uncertainty Part B 4, 011008): samples
/// go from the prior to the posterior through p(data | theta)^beta p(theta), beta = 0 ... 1, with
///     ln Z = sum over stages of ln S.
/// Moves alternate between a random walk scaled by the samples' covariance, and differences of two samples of the
/// stage before, which take a sample from one mode to another. All in the standard normal space of the prior.
/// `from`: continues a stored state. Throws InvalidInput (validate(), no likelihood anywhere) and Interrupted.
TemperedResult sample_tempered(const Posterior& posterior, const TemperedOptions& options = {},
                               const TemperedProgress& progress = {}, const TemperedState* from = nullptr);

}  // namespace kalfem
