// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/identification/record_estimate.hpp"

namespace kalfem {

/// The 95 % interval of an unknown that an estimation states.
struct StatedInterval {
  double lower = 0.0, upper = 0.0;  ///< [unit of the unknown]
  bool robust = false;              ///< it comes from the robust standard deviation, which is the larger one
  bool considered = false;          ///< it holds what is stated of numbers that are held fixed
};

/// Interval of unknown `i` after the last sample from the larger of its two standard deviations, the filter's and the
/// robust one. It is symmetric in the filter's state, which is the parameter or its transform:
///     x -+ 1.96 s sqrt(max(1, robust / stated)^2 + b^2 + d^2),
/// b: the bias that the substeps leave, in s, where they have not settled; otherwise it is small and left out. d: what
/// numbers add that are held fixed and known to a stated deviation, in s.
StatedInterval stated_interval(const RecordEstimate& estimate, Eigen::Index i);

/// The deviation of unknown `i` behind its interval: the larger one of its two, and by squares what numbers add that
/// are held fixed.
double stated_deviation(const RecordEstimate& estimate, Eigen::Index i);

/// The deviation of unknown `i` with what numbers add that are held fixed and known to a stated deviation: the root of
/// the sum of squares. Not a number where nothing is stated.
double considered_deviation(const RecordEstimate& estimate, Eigen::Index i);

}  // namespace kalfem
