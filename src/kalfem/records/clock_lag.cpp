// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/clock_lag.hpp"

#include <cmath>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/records/fractional_shift.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

void check(const Record& record, const ClockLag& lag) {
  IssueList issues;
  if (!std::isfinite(lag.delay) || !std::isfinite(lag.since))
    issues.add({}, "the delay of a clock is " + shortest(lag.delay) + " s from " + shortest(lag.since) + " s on",
               "numbers are needed", "");
  if (!(std::abs(lag.drift) < 1.0))
    issues.add({}, "the drift of a clock is " + shortest(lag.drift) + " s/s", "no clock runs that wrong",
               "give it in s/s: 50 ppm is 5e-5");
  if (!(record.sample_rate > 0.0) || !std::isfinite(record.sample_rate))
    issues.add({}, "the sampling rate is " + shortest(record.sample_rate) + " Hz", "it must be > 0", "");
  issues.raise();
}

/// Row j at other times: sample k becomes that of time_at(time of k).
template <class Times>
VectorXd at_times(const Record& record, Index j, const Times& time_at) {
  VectorXd lead(record.samples());
  for (Index k = 0; k < lead.size(); ++k) lead[k] = (time_at(record.time(k)) - record.time(k)) * record.sample_rate;
  return shifted(record.values.row(j).transpose(), lead);
}

}  // namespace

VectorXd without_lag(const Record& record, Index j, const ClockLag& lag) {
  check(record, lag);
  if (lag.drift == 0.0) return shifted(record.values.row(j).transpose(), lag.delay * record.sample_rate);
  return at_times(record, j, [&](double t) { return lag.shown(t); });
}

VectorXd with_lag(const Record& record, Index j, const ClockLag& lag) {
  check(record, lag);
  if (lag.drift == 0.0) return shifted(record.values.row(j).transpose(), -lag.delay * record.sample_rate);
  return at_times(record, j, [&](double t) { return lag.time_of(t); });
}

}  // namespace kalfem
