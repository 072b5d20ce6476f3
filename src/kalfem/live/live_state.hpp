// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

/// What a filter that is moved by its samples says of itself.
namespace kalfem {

/// Mean and standard deviation of a quantity now.
struct PresentEstimate {
  double mean = 0.0, std = 0.0;
};

/// An unknown now.
struct PresentParameter {
  std::string name, unit;
  double mean = 0.0, std = 0.0;
  double lower = 0.0, upper = 0.0;  ///< interval of 95 %
};

/// Why and when a filter stopped.
struct FilterStop {
  double time = 0.0;   ///< [s]
  std::string reason;  ///< in words
};

enum class FilterCondition {
  warming_up,  ///< it has begun, or doubted itself, and gates nothing yet
  consistent,  ///< innovations are as the filter expects
  suspicious,  ///< they are not quite, or a sensor is left out
  unusable,    ///< its numbers cannot be relied on, or it has stopped
  silent       ///< no sensor gives values
};

std::string to_string(FilterCondition condition);

enum class FilterEventKind {
  spike,      ///< a single value is far off
  stuck,      ///< a sensor gives the same value while the structure moves
  saturated,  ///< the same at an end of its range
  dead,       ///< it gives noise alone while the structure moves
  off,        ///< it does not follow the prediction
  missing,    ///< it gives no value
  back,       ///< it is taken again
  inflated,   ///< the filter has widened its deviations
  restarted   ///< the filter has begun anew from its last consistent estimate
};

std::string to_string(FilterEventKind kind);

/// Something that a filter has noticed, and what it did.
struct FilterEvent {
  double time = 0.0;  ///< of the first sample that it concerns [s]
  FilterEventKind kind = FilterEventKind::spike;
  std::string channel = {};  ///< empty: the filter itself
  std::string text = {};     ///< one sentence
};

}  // namespace kalfem
