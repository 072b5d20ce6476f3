#pragma once

#include "kalfem/system/connector_law.hpp"

namespace kalfem {

/// Spring and dashpot with a bump stop on one side or both,
///     f = k d + c v + r(d - gap_upper, v) - r(-d - gap_lower, -v),
///     r(o, w) = max(0, k_stop o + c_stop w) where the overlap o > 0, else 0:
/// the stop pushes and never pulls. Parameters k_stop [N/m], c_stop [N s/m], gap_upper [m], gap_lower [m], k [N/m],
/// c [N s/m]. An infinite gap (the default) is a side without a stop.
ConnectorLawPtr gap_law();

}  // namespace kalfem
