// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/identification/record_estimate.hpp"

namespace kalfem {

/// The 95 % interval of an unknown that an estimation states.
struct StatedInterval {
  double lower = 0.0, upper = 0.0;  ///< [unit of the unknown]
  bool robust = false;              ///< it comes from the robust standard deviation, which is the larger one
};

/// Interval of unknown `i` after the last sample from the larger of its two standard deviations, the filter's and the
/// robust one. It is symmetric in the filter's state, which is the parameter or its transform:
///     x -+ 1.96 s sqrt(max(1, robust / stated)^2 + b^2),
/// b: the bias that the substeps leave, in s, where they have not settled; otherwise it is small and left out.
StatedInterval stated_interval(const RecordEstimate& estimate, Eigen::Index i);

}  // namespace kalfem
