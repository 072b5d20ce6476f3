// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/about_estimates.hpp"

#include <algorithm>

#include "kalfem/identification/record_estimate.hpp"

namespace kalfem {

using Eigen::Index;

EstimationProblemPtr about_estimates(const EstimationProblem& problem, const RecordEstimate& estimate, double breadth) {
  auto about = std::make_shared<EstimationProblem>(problem);
  const Index last = estimate.result.unknowns.mean.cols() - 1;
  for (std::size_t i = 0; i < about->settings.unknowns.size(); ++i) {
    auto& unknown = about->settings.unknowns[i];
    const double value = estimate.result.unknowns.mean(static_cast<Index>(i), last);
    const double before = unknown.transform.slope(unknown.transform.to_state(unknown.initial));
    const double slope = unknown.transform.slope(unknown.transform.to_state(value));
    if (unknown.random_walk > 0.0 || !(slope > 1e-6 * before)) continue;
    unknown.initial = value;
    const double own = estimate.result.unknowns.deviation(static_cast<Index>(i), last);
    unknown.deviation = std::min(unknown.deviation * slope / before, breadth * own);
  }
  about->settings.substeps = estimate.augmented_model->options().substeps;
  about->settings.passes = 1;
  return about;
}

}  // namespace kalfem
