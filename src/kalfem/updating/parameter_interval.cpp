// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/parameter_interval.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/statistics/quantiles.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

constexpr double upper_tail = 0.975;  ///< probability below the upper end of a 95 % interval

double robust_half_width(const RobustStatistics& robust, Index i) {
  if (i >= robust.deviations.size() || !std::isfinite(robust.deviations[i]) || robust.degrees_of_freedom <= 0.0)
    return 0.0;
  return student_t_quantile(upper_tail, robust.degrees_of_freedom) * robust.deviations[i];
}

}  // namespace

std::optional<ParameterInterval> parameter_interval(const UpdatingParameter& parameter, Index i, double value,
                                                    const ParameterStatistics& statistics,
                                                    const RobustStatistics& robust) {
  if (i >= statistics.deviations.size() || !std::isfinite(statistics.deviations[i])) return {};
  const double stated = normal_quantile(upper_tail) * statistics.deviations[i], wide = robust_half_width(robust, i);
  const double added = i < statistics.considered.size() ? statistics.considered[i] : 0.0;
  const double half = std::hypot(std::max(stated, wide), normal_quantile(upper_tail) * added);
  return ParameterInterval{std::max(value - half, parameter.lower), std::min(value + half, parameter.upper),
                           wide > stated, added > 0.0};
}

}  // namespace kalfem
