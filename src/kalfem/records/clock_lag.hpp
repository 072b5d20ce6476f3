// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

#include "kalfem/records/record.hpp"

namespace kalfem {

/// How late a channel's clock is: the motion of time t stands in it at
///     t + delay + drift (t - since).
/// A clock that runs fast, by a positive drift, puts the same motion later and later.
struct ClockLag {
  double delay = 0.0;  ///< [s]
  double drift = 0.0;  ///< [s/s], above -1; 5e-5 is 50 ppm
  double since = 0.0;  ///< time at which the channel is late by the delay alone: the recording's first sample [s]

  [[nodiscard]] bool is_none() const { return delay == 0.0 && drift == 0.0; }
  /// Where the motion of time t stands.
  [[nodiscard]] double shown(double t) const { return t + delay + drift * (t - since); }
  /// Time of the motion that stands at t.
  [[nodiscard]] double time_of(double t) const { return since + (t - since - delay) / (1.0 + drift); }
};

/// Row j of the record with every motion at its own time; at every frequency below Nyquist, so white noise stays as
/// large. Samples that would come from beyond an end are missing. Throws InvalidInput where a number is not finite, the
/// drift is not between -1 and 1, or the sampling rate is not positive.
Eigen::VectorXd without_lag(const Record& record, Eigen::Index j, const ClockLag& lag);

/// The inverse: row j as a channel with this clock shows it.
Eigen::VectorXd with_lag(const Record& record, Eigen::Index j, const ClockLag& lag);

}  // namespace kalfem
