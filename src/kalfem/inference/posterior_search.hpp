// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/identification/record_estimate.hpp"
#include "kalfem/inference/parameter_likelihood.hpp"

namespace kalfem {

/// The likelihood of a record and where the search for the most probable parameters begins.
struct PosteriorSearch {
  ParameterLikelihood likelihood;
  Eigen::VectorXd start;
};

/// Begins at what the filter has found along the record, or at the problem's own start: where the posterior is larger.
/// From a prior's centre the likelihood of a lightly damped structure has many maxima, each a phase that fits for a
/// while; and a filter may have stopped, or ended where no structure is. `estimate`: may be null. Throws InvalidInput
/// where neither has a likelihood.
PosteriorSearch begin_search(const InferenceProblem& problem, const Record& record, const RecordEstimate* estimate);

}  // namespace kalfem
