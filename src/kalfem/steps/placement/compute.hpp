// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/steps/placement/outcome.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// What the case's `place` asks for, under the case's excitation.
PlacementOutcome run_placement(const Study& study, const Progress& progress);

}  // namespace kalfem
