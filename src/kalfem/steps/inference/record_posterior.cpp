// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/inference/posterior.hpp"

#include <cmath>

#include "kalfem/base/parallel.hpp"
#include "kalfem/steps/inference/outcome.hpp"
#include "kalfem/steps/study_results.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

using Eigen::VectorXd;

namespace {

/// What the substeps bias ln p(data | theta) by at the most probable values, and so ln Z: by Richardson from a pass
/// with twice as many, as the error falls with the square of their number. It stands beside the deviation of ln Z.
void add_substep_bias(const CaseLikelihood& likelihood, InferenceOutcome& outcome) {
  if (!likelihood.finer || !outcome.log_evidence || outcome.most_probable.size() == 0) return;
  const double finer = likelihood.finer(outcome.most_probable);
  const double bias = 4.0 / 3.0 * (finer - likelihood.log_likelihood(outcome.most_probable));
  if (!std::isfinite(bias)) return;
  outcome.evaluations += 2;
  outcome.substep_bias = bias;
  outcome.log_evidence_deviation = std::hypot(outcome.log_evidence_deviation.value_or(0.0), bias);
}

}  // namespace

CaseLikelihood posterior_of_record(const Study& study, const Record& record, const RecordEstimate* estimate,
                                   LikelihoodCheckpoint& checkpoint, const Progress& progress,
                                   InferenceOutcome& outcome) {
  const auto& plan = *study.inference;
  auto [likelihood, start] = begin_search(study, record, estimate);
  if (plan.method == PosteriorMethod::filter) {
    take_filter_posterior(study, record, *estimate, likelihood, outcome);
    add_substep_bias(likelihood, outcome);
    return likelihood;
  }
  likelihood.log_likelihood = checkpoint.remembered(study, likelihood.log_likelihood, start);
  sample_posterior(plan, {plan.prior, likelihood.log_likelihood}, start,
                   {filter_threads(study.problem->settings), search_likelihoods(likelihood, plan.samples)}, progress,
                   outcome);
  add_substep_bias(likelihood, outcome);
  return likelihood;
}

CaseLikelihood posterior_of_comparisons(const Study& study, const StudyResults& results,
                                        LikelihoodCheckpoint& checkpoint, const Progress& progress,
                                        InferenceOutcome& outcome) {
  const auto& plan = *study.inference;
  const VectorXd start = start_of(plan);
  auto likelihood = likelihood_of_comparisons(study, results);
  likelihood.log_likelihood = checkpoint.remembered(study, likelihood.log_likelihood, start);
  sample_posterior(plan, {plan.prior, likelihood.log_likelihood}, start,
                   {processors(), search_likelihoods(likelihood, plan.samples)}, progress, outcome);
  return likelihood;
}

}  // namespace kalfem
