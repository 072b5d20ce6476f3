#include "kalfem/pipeline/stages.hpp"

#include <fmt/format.h>

#include <cmath>

namespace kalfem {

using Eigen::Index;

namespace {

constexpr double far = 4.0;         ///< prior standard deviations
constexpr double nis_factor = 1.2;  ///< of the mean NIS to the expected one

std::string remedy(double estimate) {
  return fmt::format("start again from about {:.2g}, increase its std, or set transform: log", estimate);
}

}  // namespace

PriorConflicts prior_conflicts(const EstimationOutcome& outcome) {
  PriorConflicts conflicts;
  const double nis = outcome.consistency.mean_nis, expected = outcome.consistency.expected_nis;
  const auto& layout = outcome.augmented_model->layout();
  const Index last = outcome.result.state.mean.cols() - 1;
  for (Index i = 0; i < layout.unknowns; ++i) {
    const auto& unknown = outcome.augmented_model->options().unknowns[static_cast<std::size_t>(i)];
    const double start = unknown.transform.to_state(unknown.initial);
    const double deviation = unknown.deviation / unknown.transform.slope(start);
    const double moved = std::abs(outcome.result.state.mean(layout.unknown() + i, last) - start) / deviation;
    if (!(moved > far) || unknown.random_walk > 0.0) continue;
    const double estimate = outcome.result.unknowns.mean(i, last);
    const auto text =
        fmt::format("unknown '{}' ended at {:.4g} {}, {:.3g} prior standard deviations from its initial value {:.4g}",
                    unknown.name, estimate, unknown.unit, moved, unknown.initial);
    if (nis > nis_factor * expected)
      conflicts.failures.push_back(
          fmt::format("{}, and the mean NIS is {:.3g} (expected {:.3g}): do not trust the estimates; {}", text, nis,
                      expected, remedy(estimate)));
    else
      conflicts.warnings.push_back(fmt::format("{}; {}", text, remedy(estimate)));
  }
  return conflicts;
}

}  // namespace kalfem
