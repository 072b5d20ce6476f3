// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <string>

#include "kalfem/estimation/augmented_model.hpp"

namespace kalfem {

/// An unknown in relative coordinates: x = (state - initial state) per_state, the change relative to the initial value,
/// or to the prior deviation where that value is 0; under log and logit to first order.
struct MonitoredUnknown {
  explicit MonitoredUnknown(const UnknownParameter& unknown)
      : name(unknown.name),
        unit(unknown.unit),
        transform(unknown.transform),
        initial_state(transform.to_state(unknown.initial)),
        scale(unknown.initial != 0.0 ? std::abs(unknown.initial) : unknown.deviation),
        deviation(unknown.deviation / scale),
        per_state(transform.slope(initial_state) / scale),
        walk(unknown.random_walk / scale) {}

  /// In the unknown's unit.
  [[nodiscard]] double value(double relative) const {
    return transform.to_parameter(initial_state + relative / per_state);
  }

  std::string name, unit;
  ParameterTransform transform;
  double initial_state;
  double scale;      ///< [unit]
  double deviation;  ///< of the prior, relative
  double per_state;
  double walk;  ///< relative [1/sqrt(s)]
};

}  // namespace kalfem
