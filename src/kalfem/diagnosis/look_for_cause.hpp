// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/diagnosis/diagnose.hpp"
#include "kalfem/identification/record_estimate.hpp"

namespace kalfem {

/// Which mistake explains an estimation whose filter stopped or whose numbers contradict themselves. Nothing if they do
/// not, if no mistake could be behind it, or if the problem's settings do not ask for it. Takes the filter steps that
/// are left of the estimation's second thoughts; where these are too few, that is among what was left out. `parts`:
/// those that the filter's model was made of. `updated`: parameters that an updating found from the record, so that
/// they are not among those that the case holds fixed.
std::optional<Diagnosis> look_for_cause(const EstimationProblem& problem, const StructureParts& parts,
                                        const Record& record, RecordEstimate& estimate,
                                        const std::vector<std::string>& updated = {});

}  // namespace kalfem
