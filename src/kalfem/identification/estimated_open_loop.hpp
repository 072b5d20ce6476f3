// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/identification/record_estimate.hpp"

namespace kalfem {

/// Simulates the record from the estimated parameters and initial state alone, and compares both. A diverging
/// simulation is a result: the estimates do not describe the structure.
void set_open_loop(const EstimationProblem& problem, const AugmentedModelSetup& setup, RecordEstimate& estimate);

}  // namespace kalfem
