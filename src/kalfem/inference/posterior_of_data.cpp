// SPDX-License-Identifier: Apache-2.0
#include "kalfem/inference/posterior_of_data.hpp"

#include <cmath>

#include "kalfem/inference/filter_posterior.hpp"
#include "kalfem/inference/posterior_search.hpp"
#include "kalfem/inference/sample_posterior.hpp"

namespace kalfem {

using Eigen::VectorXd;

namespace {

/// What the substeps bias ln p(data | theta) by at the most probable values, and so ln Z: by Richardson from a pass
/// with twice as many, as the error falls with the square of their number. It stands beside the deviation of ln Z.
void add_substep_bias(const ParameterLikelihood& likelihood, InferenceResult& result) {
  if (!likelihood.finer || !result.log_evidence || result.most_probable.size() == 0) return;
  const double finer = likelihood.finer(result.most_probable);
  const double bias = 4.0 / 3.0 * (finer - likelihood.log_likelihood(result.most_probable));
  if (!std::isfinite(bias)) return;
  result.evaluations += 2;
  result.substep_bias = bias;
  result.log_evidence_deviation = std::hypot(result.log_evidence_deviation.value_or(0.0), bias);
}

void sample(const InferenceProblem& problem, const VectorXd& start, const InferenceAids& aids,
            ParameterLikelihood& likelihood, InferenceResult& result) {
  if (aids.remember) likelihood.log_likelihood = aids.remember(likelihood.log_likelihood, start);
  sample_posterior(problem, {problem.prior, likelihood.log_likelihood}, start,
                   {problem.threads(), search_likelihoods(likelihood, problem.samples)}, aids.progress, result);
}

}  // namespace

ParameterLikelihood posterior_of_record(const InferenceProblem& problem, const Record& record,
                                        const InferenceAids& aids, InferenceResult& result) {
  auto [likelihood, start] = begin_search(problem, record, aids.estimate);
  if (problem.method == PosteriorMethod::filter)
    take_filter_posterior(problem, record, *aids.estimate, likelihood, result);
  else
    sample(problem, start, aids, likelihood, result);
  add_substep_bias(likelihood, result);
  return likelihood;
}

ParameterLikelihood posterior_of_data(const InferenceProblem& problem, ParameterLikelihood likelihood,
                                      const InferenceAids& aids, InferenceResult& result) {
  sample(problem, start_of(problem), aids, likelihood, result);
  return likelihood;
}

}  // namespace kalfem
