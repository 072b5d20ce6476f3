// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/identification/fixed_number_study.hpp"

namespace kalfem {

/// Repeats the run of an estimate with each of up to three of the likeliest significant changes that its study found,
/// and sets `confirmed`: their linear prediction may reach too far, as along a direction that the record hardly tells a
/// change is large; and about the estimates the filter learns otherwise than from its first guess. The problem is that
/// of the estimate: it stands at the study's changes.
void confirm_asked(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup, const Record& record,
                   const RecordEstimate& estimate, FixedNumberStudy& study);

}  // namespace kalfem
