// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "kalfem/base/progress.hpp"
#include "kalfem/identification/record_estimate.hpp"
#include "kalfem/inference/inference_problem.hpp"
#include "kalfem/inference/inference_result.hpp"
#include "kalfem/inference/parameter_likelihood.hpp"

namespace kalfem {

/// Gives a likelihood that looks first at values which are known already. `start`: where its search begins.
using RememberLikelihood = std::function<LogLikelihood(const LogLikelihood& likelihood, const Eigen::VectorXd& start)>;

/// What an inference has beside its problem.
struct InferenceAids {
  /// Of the same record; null: the search begins at the initial values. PosteriorMethod::filter needs it.
  const RecordEstimate* estimate = nullptr;
  RememberLikelihood remember = {};  ///< empty: every likelihood is computed
  Progress progress = {};
};

/// Computes the posterior of a record by the problem's method into `result`: samples, moments, evidence, diagnostics
/// and warnings. Returns the likelihood that it rests on. Throws InvalidInput where no start has a likelihood, or where
/// the filter stopped whose posterior is asked for, and Interrupted.
ParameterLikelihood posterior_of_record(const InferenceProblem& problem, const Record& record,
                                        const InferenceAids& aids, InferenceResult& result);

/// The same of other data, by their likelihood. The search begins at the initial values.
ParameterLikelihood posterior_of_data(const InferenceProblem& problem, ParameterLikelihood likelihood,
                                      const InferenceAids& aids, InferenceResult& result);

}  // namespace kalfem
