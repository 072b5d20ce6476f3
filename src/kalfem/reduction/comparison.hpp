#pragma once

#include "kalfem/reduction/superelement.hpp"

namespace kalfem {

/// Band in which modes are compared [Hz]: what is asked for, or 0 for all kept modes (see ReductionOptions).
double comparison_band(const ReductionErrorIndicators& error_indicators, double asked);
/// Full and reduced modes up to a frequency [Hz], place by place, and their strains at the gauges: sets `modes` and
/// `gauges` of the indicators, the latter from the modes in the lower half. `whole`: factor of the full model's K, null
/// where it is not at hand.
void compare_modes(const LinearModel& full, const Superelement& reduced, double up_to, const StiffnessFactor* whole,
                   ReductionErrorIndicators& error_indicators);

}  // namespace kalfem
