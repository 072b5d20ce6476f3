// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "kalfem/identification/parameter_jumps.hpp"
#include "kalfem/identification/sensor_events.hpp"

namespace kalfem {

/// Whether a change goes on slowly: a drift has no place, so its `sample` is 0. Its course goes furthest between
/// `earliest` and `latest`, from `before` to `after`.
inline bool is_drift(const ParameterJump& change) { return change.sample == 0; }

/// The event of a jump names one time, that of a drift a stretch.
inline bool is_drift(const SensorEvent& event) { return event.kind == EventKind::jump && event.to > event.from; }

/// "missing", "jump", "drift" and so on, as results name it.
inline std::string kind_of(const SensorEvent& event) { return is_drift(event) ? "drift" : to_string(event.kind); }

/// A change of an unknown as an event of the record.
SensorEvent event_of(const ParameterJump& change, const UnknownParameter& unknown, const Record& record);

/// Density of a random walk [unit/sqrt(s)] whose standard deviation, over the time that a drift takes, is its change.
double random_walk_of(const SensorEvent& event, const ParameterJump& drift);

}  // namespace kalfem
