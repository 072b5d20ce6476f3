// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/steps/statics/outcome.hpp"
#include "kalfem/study/statics_plan.hpp"

namespace kalfem {

/// Solves every load case and recovers its stresses. `warnings`: load cases that are not in equilibrium with their
/// reactions.
StaticsOutcome run_statics(const StaticsPlan& plan, std::vector<std::string>& warnings);

}  // namespace kalfem
