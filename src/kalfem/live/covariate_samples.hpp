// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>

namespace kalfem {

/// The values of a covariate that have come, at any times.
class CovariateSamples {
public:
  /// One that is no number counts as not sent.
  void add(double time, double value);
  /// Mean over a window; if it has no value, the latest one before it that is at most `held` old; otherwise not a
  /// number. What is older than the window's end is forgotten, but for the latest value.
  double mean(double start, double end, double held);

  static void transfer(auto& self, auto& archive) {
    archive(self.times_);
    archive(self.values_);
  }

private:
  std::deque<double> times_, values_;  ///< ascending in time
};

}  // namespace kalfem
