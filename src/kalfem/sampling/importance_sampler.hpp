// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/base/progress.hpp"
#include "kalfem/sampling/normal_approximation.hpp"
#include "kalfem/sampling/posterior.hpp"
#include "kalfem/sampling/posterior_mode.hpp"

namespace kalfem {

struct ImportanceOptions {
  int samples = 1000;  ///< N, those discarded included; beside them the search takes likelihoods
  int degrees = 5;     ///< of freedom of the Student t distribution that proposes
  /// Part of the samples that is drawn from the prior, which bounds the weights by L_max / (share Z) and can show that
  /// the search missed a mode.
  double prior_share = 0.1;
  double efficiency = 0.5;   ///< the proposal is fitted anew where effective samples / samples is below
  int max_iterations = 100;  ///< of the search for the maximum
  double decrement = 1e-3;   ///< it ends where a Newton step would raise the log-density by less
  int random_starts = 0;     ///< samples of the prior to search from, beside its median or `start`
  /// Likelihoods that searches from further samples of the prior may take, which end when none tells of another
  /// maximum; see find_peaks(). 0: none.
  long long search_likelihoods = 0;
  std::optional<Eigen::VectorXd> start;  ///< theta
  std::uint64_t seed = 1;
  int threads = 1;  ///< results do not depend on it
};

IssueList validate(const ImportanceOptions& options);

struct ImportanceResult {
  SampleSet samples;                    ///< with weights; N, 3 N / 4 or N / 2, depending on when q was last fitted
  double log_evidence = 0.0;            ///< ln Z = ln mean weight
  double log_evidence_deviation = 0.0;  ///< standard error
  double effective_samples = 0.0;       ///< 1 / sum of the squared normalised weights
  double k_hat = 0.0;                   ///< shape of the tail of the weights, see smooth_weights()
  NormalApproximation approximation;    ///< moments of the weighted samples over z, for MetropolisOptions::start
  std::vector<PosteriorMode> modes;     ///< about the maxima found, with at least least_mode_weight, the heaviest first
  int prior_starts = 0;                 ///< searches from samples of the prior, see unseen_share()
  std::vector<std::string> warnings;    ///< why not to trust the result, in words; empty: nothing speaks against it
  long long evaluations = 0;            ///< of the likelihood, search included

  /// k_hat below k_hat_limit() of the number of samples, at most 0.7, and at least 100 effective samples.
  [[nodiscard]] bool reliable() const;
};

/// Corrects the Laplace approximation by importance sampling, in the standard normal space z of the prior:
///     f(z) = p(data | theta(z)) N(z; 0, I),   w_i = f(z_i) / q(z_i),   z_i ~ q,   Z = mean w_i.
/// q is a Student t distribution about each maximum of f that the search found, with the inverse of the negative
/// Hessian there (no wider than the prior in any direction), beside a share of the prior itself. If few samples are
/// effective after a quarter and after half of them, the t distributions are fitted to the weighted samples (Cappe,
/// Douc, Guillin, Marin and Robert 2008, Stat. Comput. 18, 447-459) and keep a quarter of the first ones beside them.
/// The samples before a fit are discarded: if they are kept, with the mean of all proposals as q (Cornuet, Marin, Mira
/// and Robert 2012, Scand. J. Stat. 39, 798-812), ln Z is too low by 0.06 for ten parameters and N = 1000. The largest
/// weights are smoothed, see smooth_weights(). A mode that neither a search nor a sample of the prior hit remains
/// unseen; unseen_share(prior_starts) bounds the prior that leads to it. A sample belongs to the modes by the shares of
/// their t distributions in q. Throws InvalidInput (validate(); a start that does not fit; no likelihood at any start
/// or sample) and Interrupted.
ImportanceResult sample_importance(const Posterior& posterior, const ImportanceOptions& options = {},
                                   const Progress& progress = {});

}  // namespace kalfem
