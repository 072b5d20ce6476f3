#include "kalfem/pipeline/stated_interval.hpp"

#include <tuple>

namespace kalfem {

using Eigen::Index;

StatedInterval stated_interval(const EstimationOutcome& outcome, Index i) {
  const auto& [state, unknowns] = std::tie(outcome.result.state, outcome.result.unknowns);
  const Index last = state.mean.cols() - 1, row = outcome.augmented_model->layout().unknown() + i;
  const double stated = unknowns.deviation(i, last), robust = outcome.robust_deviation[i];
  const bool wider = stated > 0.0 && robust > stated;  // false where the robust one is not a number
  const auto& transform = outcome.augmented_model->options().unknowns[static_cast<std::size_t>(i)].transform;
  const auto interval = confidence_interval(transform, state.mean(row, last),
                                            state.deviation(row, last) * (wider ? robust / stated : 1.0));
  return {interval.lower, interval.upper, wider};
}

}  // namespace kalfem
