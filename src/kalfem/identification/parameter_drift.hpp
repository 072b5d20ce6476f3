// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/identification/parameter_jumps.hpp"
#include "kalfem/identification/sensor_events.hpp"

namespace kalfem {

/// A change of an unknown as an event of the record.
SensorEvent event_of(const ParameterJump& change, const UnknownParameter& unknown, const Record& record);

/// Density of a random walk [unit/sqrt(s)] whose standard deviation, over the time that a drift takes, is its change.
double random_walk_of(const SensorEvent& event, const ParameterJump& drift);

}  // namespace kalfem
