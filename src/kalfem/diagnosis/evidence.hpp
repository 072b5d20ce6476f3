// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/diagnosis/hypothesis.hpp"

namespace kalfem {

/// Every mistake that the run suggests, with first guesses of its number from what runs over the record say: each
/// sensor beside its prediction by the others, each excitation beside what it explains, the motion of connectors.
/// They hold references to `input` and `base`.
std::vector<Hypothesis> all_hypotheses(const DiagnosisInput& input, const FilterRun& base,
                                       const EstimationOptions& options);

/// How many such runs there are.
Eigen::Index runs_for_hypotheses(const FilterRun& base);

}  // namespace kalfem
