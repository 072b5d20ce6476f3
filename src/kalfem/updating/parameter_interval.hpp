// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "kalfem/updating/robust_statistics.hpp"

namespace kalfem {

/// The 95 % interval of an updated parameter.
struct ParameterInterval {
  double lower = 0.0, upper = 0.0;  ///< [unit of the parameter]
  bool robust = false;              ///< it comes from the robust standard deviation, whose interval is the wider one
  bool considered = false;          ///< it holds what is stated of numbers that are held fixed
};

/// The wider one of
///     theta -+ 1.96 std    and    theta -+ t std_robust,
/// with the 97.5 % quantile t of Student's distribution for the degrees of freedom of the robust deviation, cut at the
/// bounds; by squares wider by 1.96 of what stated fixed numbers add to the deviation. Empty where there is no
/// deviation: at a bound, held, undetermined.
std::optional<ParameterInterval> parameter_interval(const UpdatingParameter& parameter, Eigen::Index i, double value,
                                                    const ParameterStatistics& statistics,
                                                    const RobustStatistics& robust);

}  // namespace kalfem
