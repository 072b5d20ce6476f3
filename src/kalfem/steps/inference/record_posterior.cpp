// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/inference/posterior.hpp"

#include "kalfem/base/parallel.hpp"
#include "kalfem/steps/inference/outcome.hpp"
#include "kalfem/steps/study_results.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

using Eigen::VectorXd;

CaseLikelihood posterior_of_record(const Study& study, const Record& record, const RecordEstimate* estimate,
                                   LikelihoodCheckpoint& checkpoint, const Progress& progress,
                                   InferenceOutcome& outcome) {
  const auto& plan = *study.inference;
  auto [likelihood, start] = begin_search(study, record, estimate);
  if (plan.method == PosteriorMethod::filter) {
    take_filter_posterior(study, record, *estimate, likelihood, outcome);
    return likelihood;
  }
  likelihood.log_likelihood = checkpoint.remembered(study, likelihood.log_likelihood, start);
  sample_posterior(plan, {plan.prior, likelihood.log_likelihood}, start, filter_threads(study.problem->settings),
                   progress, outcome);
  return likelihood;
}

CaseLikelihood posterior_of_comparisons(const Study& study, const StudyResults& results,
                                        LikelihoodCheckpoint& checkpoint, const Progress& progress,
                                        InferenceOutcome& outcome) {
  const auto& plan = *study.inference;
  const VectorXd start = start_of(plan);
  auto likelihood = likelihood_of_comparisons(study, results);
  likelihood.log_likelihood = checkpoint.remembered(study, likelihood.log_likelihood, start);
  sample_posterior(plan, {plan.prior, likelihood.log_likelihood}, start, processors(), progress, outcome);
  return likelihood;
}

}  // namespace kalfem
