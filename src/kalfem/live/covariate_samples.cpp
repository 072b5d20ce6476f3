// SPDX-License-Identifier: Apache-2.0
#include "kalfem/live/covariate_samples.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kalfem {

void CovariateSamples::add(double time, double value) {
  constexpr std::size_t most = 1'000'000;  // that wait, beyond which the earliest goes
  if (!std::isfinite(time) || !std::isfinite(value)) return;
  const auto place = std::ranges::upper_bound(times_, time) - times_.begin();
  times_.insert(times_.begin() + place, time);
  values_.insert(values_.begin() + place, value);
  if (times_.size() <= most) return;
  times_.pop_front();
  values_.pop_front();
}

double CovariateSamples::mean(double start, double end, double held) {
  double sum = 0.0, before = std::numeric_limits<double>::quiet_NaN();
  int count = 0;
  std::size_t passed = 0;
  for (; passed < times_.size() && times_[passed] < end; ++passed)
    if (times_[passed] >= start) {
      sum += values_[passed];
      ++count;
    } else if (times_[passed] >= start - held) {
      before = values_[passed];
    }
  for (; passed > 1; --passed) {
    times_.pop_front();
    values_.pop_front();
  }
  return count > 0 ? sum / count : before;
}

}  // namespace kalfem
