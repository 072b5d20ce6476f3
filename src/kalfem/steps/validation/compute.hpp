// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/steps/study_results.hpp"
#include "kalfem/steps/validation/outcome.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// Simulates the validation part of the case, and for comparison its own record, in open loop with the structure at the
/// estimates. `base`: the parts that the estimated parameters are put into, such as updated ones.
ValidationOutcome run_validation(const Study& study, const StructureParts& base, const StudyResults& results);

}  // namespace kalfem
