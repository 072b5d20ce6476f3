#include "kalfem/identification/stated_interval.hpp"

#include <tuple>

namespace kalfem {

using Eigen::Index;

StatedInterval stated_interval(const RecordEstimate& estimate, Index i) {
  const auto& [state, unknowns] = std::tie(estimate.result.state, estimate.result.unknowns);
  const Index last = state.mean.cols() - 1, row = estimate.augmented_model->layout().unknown() + i;
  const double stated = unknowns.deviation(i, last), robust = estimate.robust_deviation[i];
  const bool wider = stated > 0.0 && robust > stated;  // false where the robust one is not a number
  const auto& transform = estimate.augmented_model->options().unknowns[static_cast<std::size_t>(i)].transform;
  const auto interval = confidence_interval(transform, state.mean(row, last),
                                            state.deviation(row, last) * (wider ? robust / stated : 1.0));
  return {interval.lower, interval.upper, wider};
}

}  // namespace kalfem
