// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "kalfem/steps/study_results.hpp"

namespace kalfem {

/// What stands in the place of a verdict where a run has none. `correlated`: by a correlation.
std::string why_no_verdict(bool correlated);
std::string why_no_verdict(const StudyResults& results);

/// Whether a run has a verdict: a step fitted or tested the model by measurements, or one of them failed, or a mistake
/// of a modal test's set-up was found. Modes, statics, frequency responses, simulations and placements alone are
/// consistent with everything, so they have none: `verdict.state` of summary.json is null.
bool has_verdict(const StudyResults& results);

}  // namespace kalfem
