// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/placement/placement.hpp"

namespace kalfem {

/// Where sensors tell most of the parameters.
using PlacementOutcome = SensorChoice;

}  // namespace kalfem
