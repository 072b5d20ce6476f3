// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/unknown_scores.hpp"

#include "kalfem/identification/record_estimate.hpp"

namespace kalfem {

using Eigen::Index;

std::vector<UnknownScore> scores_of_unknowns(const RecordEstimate& estimate) {
  const auto& history = estimate.result.unknowns_history;
  if (history.empty() || estimate.result.failure || history.stride != 1) return {};
  const auto& unknowns = estimate.augmented_model->options().unknowns;
  const Scores scores = scores_of(history);
  std::vector<UnknownScore> found;
  for (std::size_t i = 0; i < history.unknowns.size(); ++i) {
    const auto& unknown = unknowns[static_cast<std::size_t>(history.unknowns[i])];
    const auto row = static_cast<Index>(i);
    const double slope = unknown.transform.slope(history.mean(row, history.last()));  // d theta / d state
    found.push_back({unknown.name, scores.value.row(row).transpose() / slope});
  }
  return found;
}

}  // namespace kalfem
