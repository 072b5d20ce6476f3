// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace kalfem {

/// A quantity that comes with the stream and that parameters depend on, such as a temperature: no sensor of the model.
struct Covariate {
  std::string name;
  double effect = 0.01;  ///< prior deviation of its effect: relative change of a parameter per unit of the covariate
};

/// When a filter that runs by itself gives an alarm on a change of its unknowns. Changes are relative to an unknown's
/// initial value, or to its prior deviation where that value is 0.
struct ChangeOptions {
  double window = 60.0;     ///< time over which an estimate is formed [s]
  int reference = 60;       ///< windows before the first alarm: what changes are compared with
  int memory = 60;          ///< latest windows in which a change that is not yet known may have begun
  double level = 0.02;      ///< smallest change that gives an alarm
  double hysteresis = 0.3;  ///< an alarm ends where the change has fallen below (1 - hysteresis) level
  int persistence = 2;      ///< windows in succession that must show the same
  /// Mean time between false alarms of a clean stream, all unknowns together [s]: 300 h.
  double false_alarms_every = 1.08e6;
  std::vector<Covariate> covariates = {};
};

}  // namespace kalfem
