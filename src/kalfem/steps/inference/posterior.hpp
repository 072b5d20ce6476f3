// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/sampling/posterior.hpp"
#include "kalfem/steps/inference/case_likelihood.hpp"
#include "kalfem/steps/inference/likelihood_checkpoint.hpp"
#include "kalfem/steps/inference/outcome.hpp"
#include "kalfem/steps/study_results.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// The likelihood of a case's record and where the search for the most probable parameters begins.
struct PosteriorSearch {
  CaseLikelihood likelihood;
  Eigen::VectorXd start;
};

/// Begins at what the filter has found along the record, or at the plan's own start: where the posterior is larger.
/// From a prior's centre the likelihood of a lightly damped structure has many maxima, each a phase that fits for a
/// while; and a filter may have stopped, or ended where no structure is. `estimate`: may be null. Throws InvalidInput
/// where neither has a likelihood.
PosteriorSearch begin_search(const Study& study, const Record& record, const RecordEstimate* estimate);

/// Computes the posterior of a record by the plan's method into `outcome`; the likelihood that it rests on. `estimate`:
/// of the same record; null where there is none, which method: filter needs. Throws InvalidInput where no start has a
/// likelihood or the filter stopped, and Interrupted.
CaseLikelihood posterior_of_record(const Study& study, const Record& record, const RecordEstimate* estimate,
                                   LikelihoodCheckpoint& checkpoint, const Progress& progress,
                                   InferenceOutcome& outcome);

/// The same of the comparisons of its updating.
CaseLikelihood posterior_of_comparisons(const Study& study, const StudyResults& results,
                                        LikelihoodCheckpoint& checkpoint, const Progress& progress,
                                        InferenceOutcome& outcome);

/// What a sampling may take.
struct SamplingEffort {
  int threads = 1;                   ///< results do not depend on it
  long long search_likelihoods = 0;  ///< for searches from samples of the prior, see search_likelihoods()
};

/// Computes the posterior by the plan's method, whose search begins at `start`: samples, moments, evidence, diagnostics
/// and warnings of the outcome. Throws InvalidInput where no start has a likelihood, and Interrupted.
void sample_posterior(const InferencePlan& plan, const Posterior& posterior, const Eigen::VectorXd& start,
                      const SamplingEffort& effort, const Progress& progress, InferenceOutcome& outcome);

/// Moments and correlation of the outcome's samples.
void summarise_posterior(InferenceOutcome& outcome);

/// The posterior as the filter has it at the record's end, normal in the coordinates of its state, where positive
/// parameters are logarithms; and the evidence of that normal distribution about the estimate. Exact for linear systems
/// whose unknowns enter linearly, otherwise within the filter's approximation. Its deviation is how far the evidence is
/// from ln p(y_1..y_N) of one pass with every unknown in the state under its prior, the same where the filter is exact.
/// Throws InvalidInput where the filter stopped.
void take_filter_posterior(const Study& study, const Record& record, const RecordEstimate& estimate,
                           const CaseLikelihood& likelihood, InferenceOutcome& outcome);

}  // namespace kalfem
