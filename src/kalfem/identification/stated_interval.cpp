// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/stated_interval.hpp"

#include <cmath>
#include <limits>
#include <tuple>

namespace kalfem {

using Eigen::Index;

StatedInterval stated_interval(const RecordEstimate& estimate, Index i) {
  const auto& [state, unknowns] = std::tie(estimate.result.state, estimate.result.unknowns);
  const Index last = state.mean.cols() - 1, row = estimate.augmented_model->layout().unknown() + i;
  const double stated = unknowns.deviation(i, last), robust = estimate.robust_deviation[i];
  const bool wider = stated > 0.0 && robust > stated;  // false where the robust one is not a number
  const auto& substeps = estimate.substeps;
  const double bias = substeps.limited && substeps.bias.size() > i ? substeps.bias[i] : 0.0;
  const auto& transform = estimate.augmented_model->options().unknowns[static_cast<std::size_t>(i)].transform;
  const auto& added = estimate.considered_deviation;
  const double considered = stated > 0.0 && added.size() > i ? added[i] / stated : 0.0;
  const auto interval =
      confidence_interval(transform, state.mean(row, last),
                          state.deviation(row, last) * std::hypot(wider ? robust / stated : 1.0, bias, considered));
  return {interval.lower, interval.upper, wider, considered > 0.0};
}

double stated_deviation(const RecordEstimate& estimate, Index i) {
  const auto& deviation = estimate.result.unknowns.deviation;
  const auto& added = estimate.considered_deviation;
  return std::hypot(std::fmax(deviation(i, deviation.cols() - 1), estimate.robust_deviation[i]),
                    added.size() > i ? added[i] : 0.0);
}

double considered_deviation(const RecordEstimate& estimate, Index i) {
  const auto& added = estimate.considered_deviation;
  if (added.size() <= i) return std::numeric_limits<double>::quiet_NaN();
  const auto& deviation = estimate.result.unknowns.deviation;
  return std::hypot(deviation(i, deviation.cols() - 1), added[i]);
}

}  // namespace kalfem
