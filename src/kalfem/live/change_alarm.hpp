// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace kalfem {

/// A parameter has changed since the reference windows. Relative to its initial value, or to its prior deviation where
/// that value is 0.
struct ParameterChange {
  std::string parameter;
  double change = 0.0, std = 0.0;
  double lower = 0.0, upper = 0.0;      ///< interval of 95 %
  double since = 0.0;                   ///< start of the window in which the latest step is most likely [s]
  double earliest = 0.0, latest = 0.0;  ///< it lies between these with 95 % [s]
  double statistic = 0.0;               ///< of the latest step when it was found, in deviations
};

enum class AlarmKind {
  raised,   ///< a parameter has changed by the level or more
  changed,  ///< one that had changed has changed again
  ended     ///< its change has fallen below the level less the hysteresis
};

std::string to_string(AlarmKind kind);

struct Alarm {
  std::int64_t number = 0;  ///< from 1 on
  AlarmKind kind = AlarmKind::raised;
  double time = 0.0;  ///< end of the window after which it was given [s]
  ParameterChange what = {};
  std::string text = {};  ///< one sentence
};

}  // namespace kalfem
