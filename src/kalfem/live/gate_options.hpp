// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kalfem {

/// When a filter that runs by itself leaves a sensor's values out, when it takes them again, and when it doubts itself.
/// Numbers of samples where nothing else is said. In a clean stream the gates change no bit: a value is left out by
/// chance once in 500 million.
struct GateOptions {
  /// A value is left out where its innovation, given the other channels' of the same sample, is larger than this in
  /// expected deviations.
  double limit = 6.0;
  int warm_up = 1000;     ///< at the start, and after the filter has doubted itself: innovations are not gated yet
  int memory = 100;       ///< latest values by which a channel is judged; so many good ones bring it back
  int suspend_after = 5;  ///< values left out among these after which the channel is out until it is good again
  int stuck = 8;          ///< equal values in succession, while the prediction moves, after which a channel is stuck
  /// So long may more than half of the working channels contradict the filter before the filter is at fault.
  int patience = 1000;
  double inflation = 10.0;  ///< it then widens its deviations by this factor, those of unknowns at most to their prior
  int silence = 100;        ///< without a value, after which a channel counts as missing, and all as silence
  int most_events = 1000;   ///< the latest ones that are kept
};

}  // namespace kalfem
