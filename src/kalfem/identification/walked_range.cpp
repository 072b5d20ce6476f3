// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/walked_range.hpp"

#include <algorithm>
#include <limits>

namespace kalfem {

using Eigen::Index;

std::optional<WalkedRange> walked_range(const RecordEstimate& estimate, Index i) {
  const auto& unknown = estimate.augmented_model->options().unknowns[static_cast<std::size_t>(i)];
  if (!(unknown.random_walk > 0.0)) return std::nullopt;
  const auto& state = estimate.result.state;
  const Index row = estimate.augmented_model->layout().unknown() + i, samples = state.mean.cols();
  constexpr double infinity = std::numeric_limits<double>::infinity();
  WalkedRange range{infinity, -infinity, infinity, -infinity};
  for (Index k = std::min(estimate.settled, samples - 1); k < samples; ++k) {
    const double value = estimate.result.unknowns.mean(i, k);
    const auto band = confidence_interval(unknown.transform, state.mean(row, k), state.deviation(row, k));
    range = {std::min(range.least, value), std::max(range.greatest, value), std::min(range.lower, band.lower),
             std::max(range.upper, band.upper)};
  }
  return range;
}

}  // namespace kalfem
