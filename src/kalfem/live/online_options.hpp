// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/live/gate_options.hpp"

namespace kalfem {

/// An input at one instant: its value with its first and second time derivative. A force needs its value alone, an
/// accelerated base too; a moving ground acts through velocity and acceleration.
struct InputSample {
  double value = 0.0, rate = 0.0, acceleration = 0.0;
};

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

/// How a filter treats samples as they come.
struct OnlineOptions {
  /// Samples by which the filter stays behind predict_values(). Its inputs are then the cubic spline of estimate(), to
  /// 0.27^input_delay of its curvature. 0: no delay, and inputs that are straight between samples. The velocity of a
  /// moved ground is then a staircase, which biases stiffnesses and damping; content of an input at a part x of the
  /// sampling rate is too small by a part 3.3 x^2.
  int input_delay = 8;
  /// Latest samples by which usable() and verdict() judge.
  int window = 2000;
  /// Samples N by which the smoothed estimates stay behind the filter: of sample k - N, from all samples up to k. They
  /// cost N backward steps each time they are asked for, one more evaluation of each map a sample, and 8 N n^2 bytes
  /// for n states. 0: none, and the filter's bits are those without the option.
  int lag = 0;
  /// When sensors are left out and taken again. Without gates every value is taken as it comes, and the filter never
  /// doubts itself.
  std::optional<GateOptions> gates = {};
  /// When a change of an unknown gives an alarm. Empty: none is looked for.
  std::optional<ChangeOptions> changes = {};
};

/// When a LiveFilter goes on without what has not come.
struct LiveOptions {
  double start = 0.0;     ///< time of sample 0 [s]
  double horizon = 10.0;  ///< by so much later than another channel may a channel come [s]
  /// Samples that begin later than this behind the latest ones are refused: their time must be wrong [s]. Empty: ten
  /// horizons.
  std::optional<double> longest_gap = {};
  OnlineOptions filter = {};
};

/// Throws InvalidInput with every option that is out of range. `step`: from sample to sample [s].
void check(const OnlineOptions& options, double step);

}  // namespace kalfem
