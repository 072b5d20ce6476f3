// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/identification/estimation_problem.hpp"

namespace kalfem {

struct RecordEstimate;

/// The problem with the unknowns beginning at the estimates, within `breadth` of their deviations or what was stated
/// where that is less, and with the estimate's substeps, for one pass. Random walks keep their prior.
EstimationProblemPtr about_estimates(const EstimationProblem& problem, const RecordEstimate& estimate, double breadth);

}  // namespace kalfem
