// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// Expected crossings of a threshold c per window by the generalised likelihood ratio of one parameter without a
/// change, max |S_n - S_k| / sqrt(n - k) over n - k <= memory, S the sum of independent standard normal values:
///     c exp(-c^2 / 2) / sqrt(2 pi)  int_{c / sqrt(memory)}^{c} x nu(x)^2 dx,
///     nu(x) = 2 / x^2 exp(-2 sum_n Phi(-x sqrt(n) / 2) / n)
/// (Siegmund and Venkatraman 1995, with the earliest change limited as in Lai 1995).
double false_alarm_rate(double threshold, int memory);

/// The threshold, in deviations, at which so many parameters together give one false alarm in `windows` windows.
double change_threshold(double windows, int memory, Eigen::Index parameters);

}  // namespace kalfem
