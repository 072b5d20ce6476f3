// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/parameter_drift.hpp"

#include <cmath>

#include <fmt/format.h>

namespace kalfem {

SensorEvent event_of(const ParameterJump& change, const UnknownParameter& unknown, const Record& record) {
  const double difference = change.after - change.before;
  const double from = record.time(change.earliest), to = record.time(change.latest);
  if (change.is_drift())
    return {.kind = EventKind::drift,
            .channel = unknown.name,
            .from = from,
            .to = to,
            .count = change.latest - change.earliest + 1,
            .text = fmt::format("'{}' drifts from {:.6g} {} at {:.4g} s to {:.6g} {} at {:.4g} s (by {:.3g}, standard "
                                "deviation {:.2g})",
                                unknown.name, change.before, unknown.unit, from, change.after, unknown.unit, to,
                                difference, change.deviation)};
  const double time = record.time(change.sample);
  return {.kind = EventKind::jump,
          .channel = unknown.name,
          .from = time,
          .to = time,
          .count = record.samples() - change.sample,
          .text = fmt::format("'{}' changes at {:.6g} s (between {:.4g} and {:.4g} s) from {:.6g} to {:.6g} {} (by "
                              "{:.3g}, standard deviation {:.2g})",
                              unknown.name, time, from, to, change.before, change.after, unknown.unit, difference,
                              change.deviation)};
}

double random_walk_of(const SensorEvent& event, const ParameterJump& drift) {
  return std::abs(drift.after - drift.before) / std::sqrt(event.to - event.from);
}

}  // namespace kalfem
