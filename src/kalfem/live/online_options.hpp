// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "kalfem/live/change_options.hpp"
#include "kalfem/live/gate_options.hpp"

namespace kalfem {

/// An input at one instant: its value with its first and second time derivative. A force needs its value alone, an
/// accelerated base too; a moving ground acts through velocity and acceleration.
struct InputSample {
  double value = 0.0, rate = 0.0, acceleration = 0.0;
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
