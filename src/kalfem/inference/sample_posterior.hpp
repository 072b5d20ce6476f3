// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/base/progress.hpp"
#include "kalfem/inference/inference_problem.hpp"
#include "kalfem/inference/inference_result.hpp"
#include "kalfem/sampling/posterior.hpp"

namespace kalfem {

/// What a sampling may take.
struct SamplingEffort {
  int threads = 1;                   ///< results do not depend on it
  long long search_likelihoods = 0;  ///< for searches from samples of the prior, see search_likelihoods()
};

/// Computes the posterior by the problem's method, whose search begins at `start`: samples, moments, evidence,
/// diagnostics and warnings of the result. Throws InvalidInput where no start has a likelihood, and Interrupted.
void sample_posterior(const InferenceProblem& problem, const Posterior& posterior, const Eigen::VectorXd& start,
                      const SamplingEffort& effort, const Progress& progress, InferenceResult& result);

/// Moments and quantiles of the prior of each parameter.
std::vector<ParameterSummary> summarise_prior(const JointPrior& prior);

/// Moments and correlation of the result's samples.
void summarise_posterior(InferenceResult& result);

}  // namespace kalfem
