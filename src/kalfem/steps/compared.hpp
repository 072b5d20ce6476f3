// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/steps/study_results.hpp"

namespace kalfem {

/// What stands in the place of a verdict where a run compared nothing.
inline constexpr const char* nothing_compared = "nothing was compared with measurements";

/// Whether a run has a verdict: a step compared the model with measurements, or one of them failed. Modes, statics,
/// frequency responses, simulations and placements alone are consistent with everything, so they have none:
/// `verdict.state` of summary.json is null.
bool has_verdict(const StudyResults& results);

}  // namespace kalfem
