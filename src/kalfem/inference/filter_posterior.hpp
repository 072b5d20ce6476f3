// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/identification/record_estimate.hpp"
#include "kalfem/inference/inference_result.hpp"
#include "kalfem/inference/parameter_likelihood.hpp"

namespace kalfem {

/// The posterior as the filter has it at the record's end, normal in the coordinates of its state, where positive
/// parameters are logarithms; and the evidence of that normal distribution about the estimate. Exact for linear systems
/// whose unknowns enter linearly, otherwise within the filter's approximation. Its deviation is how far the evidence is
/// from ln p(y_1..y_N) of one pass with every unknown in the state under its prior, the same where the filter is exact.
/// Throws InvalidInput where the filter stopped.
void take_filter_posterior(const InferenceProblem& problem, const Record& record, const RecordEstimate& estimate,
                           const ParameterLikelihood& likelihood, InferenceResult& result);

/// The filter's unknowns at the record's end, and those that a search found, beside the posterior.
std::vector<FilterComparison> beside_filter(const InferenceResult& result, const RecordEstimate& estimate);

}  // namespace kalfem
