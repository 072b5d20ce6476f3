// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/reduction/superelement.hpp"

namespace kalfem {

/// Full and reduced modes up to a frequency [Hz], 0: that of all kept modes (see ReductionOptions), place by place, and
/// their strains at the gauges, from the modes in the lower half. Sets `full_modes`, at least so many, of the
/// superelement and `modes`, `gauges` and `compare_seconds` of its indicators. `whole`: factor of the full model's K,
/// null where it is not at hand.
void compare_modes(const LinearModel& full, double up_to, Eigen::Index at_least, const StiffnessFactor* whole,
                   Superelement& element);

}  // namespace kalfem
