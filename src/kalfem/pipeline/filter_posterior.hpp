// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/pipeline/case_likelihood.hpp"

namespace kalfem {

/// The posterior as the filter has it at the record's end, normal in the coordinates of its state, where positive
/// parameters are logarithms; and the evidence of that normal distribution about the estimate. Exact for linear systems
/// whose unknowns enter linearly, otherwise within the filter's approximation. Its deviation is how far the evidence is
/// from ln p(y_1..y_N) of one pass with every unknown in the state under its prior, the same where the filter is exact.
/// Throws InvalidInput where the filter stopped.
void take_filter_posterior(const Study& study, const Record& record, const RecordEstimate& estimate,
                           const CaseLikelihood& likelihood, InferenceOutcome& outcome);

}  // namespace kalfem
