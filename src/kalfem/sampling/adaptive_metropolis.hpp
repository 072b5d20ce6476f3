// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "kalfem/sampling/convergence.hpp"
#include "kalfem/sampling/normal_approximation.hpp"
#include "kalfem/sampling/posterior.hpp"

namespace kalfem {

struct MetropolisOptions {
  int chains = 4;
  int warm_up = 2000;        ///< draws in which each chain adapts; not kept
  int draws = 4000;          ///< kept of each chain
  int block = 100;           ///< draws between two states that may be stored
  double acceptance = 0.25;  ///< rate that the scale is adapted to
  /// What is known of the posterior over z, such as ImportanceResult::approximation: chains start about its mean, twice
  /// as wide, and with its covariance. A warm-up of some hundred draws then suffices.
  std::optional<NormalApproximation> start;
  std::uint64_t seed = 1;
  int threads = 1;  ///< results do not depend on it
};

IssueList validate(const MetropolisOptions& options);

/// One chain, in the standard normal space of the prior.
struct MetropolisChain {
  Eigen::VectorXd z;
  double log_likelihood = 0.0;
  Eigen::VectorXd mean;        ///< of the warm-up, exponentially forgotten
  Eigen::MatrixXd covariance;  ///< of the warm-up
  double log_scale = 0.0;
  long long accepted = 0;  ///< among the kept draws
  Eigen::MatrixXd draws;   ///< p x draws so far
  Eigen::VectorXd draws_log_likelihood;
};

/// All that the next block starts from; continued, it gives the same bits.
struct MetropolisState {
  int done = 0;  ///< draws of each chain, warm-up included
  long long evaluations = 0;
  std::vector<MetropolisChain> chains;
};

using MetropolisProgress = std::function<void(const MetropolisState&)>;

struct MetropolisResult {
  SampleSet samples;
  std::vector<Convergence> convergence;  ///< one per parameter
  Eigen::VectorXd acceptance;            ///< of each chain
  MetropolisState state;
  bool converged = false;  ///< every parameter: Convergence::reached()
};

/// Random-walk Metropolis with a covariance and a scale that each chain learns in its warm-up and then keeps (Haario,
/// Saksman and Tamminen 2001, Bernoulli 7, 223-242; Andrieu and Thoms 2008, Stat. Comput. 18, 343-373, algorithm 4).
/// Chains start from independent samples of the prior, or of a t distribution about `options.start` with twice its
/// deviations, so that split R-hat tells where they have not met. Chains about one mode cannot tell of another.
/// `from`: continues a stored state. Throws InvalidInput (options; a start that does not fit or is not positive
/// definite; no start with a likelihood) and Interrupted.
MetropolisResult sample_metropolis(const Posterior& posterior, const MetropolisOptions& options = {},
                                   const MetropolisProgress& progress = {}, const MetropolisState* from = nullptr);

}  // namespace kalfem
