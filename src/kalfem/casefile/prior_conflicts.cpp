#include "kalfem/casefile/prior_conflicts.hpp"

#include <fmt/format.h>

#include <cmath>

namespace kalfem {

using Eigen::Index;

namespace {

constexpr double far = 4.0;         ///< prior standard deviations
constexpr double nis_factor = 1.2;  ///< of the mean NIS to the expected one, either way

bool is_inconsistent(const ConsistencySummary& consistency) {
  const double ratio = consistency.mean_nis / consistency.expected_nis;
  return ratio > nis_factor || ratio < 1.0 / nis_factor;
}

}  // namespace

std::vector<std::string> prior_conflicts(const EstimationStage& stage) {
  std::vector<std::string> conflicts;
  const auto& layout = stage.observer->layout();
  const Index last = stage.result.state.mean.cols() - 1;
  for (Index i = 0; i < layout.unknowns; ++i) {
    const auto& unknown = stage.observer->options().unknowns[static_cast<std::size_t>(i)];
    const double start = unknown.transform.to_state(unknown.initial);
    const double deviation = unknown.deviation / unknown.transform.slope(start);
    const double moved = std::abs(stage.result.state.mean(layout.unknown() + i, last) - start) / deviation;
    if (!(moved > far) || unknown.random_walk > 0.0) continue;
    const double estimate = stage.result.unknowns.mean(i, last);
    std::string text =
        fmt::format("unknown '{}' ended at {:.4g} {}, {:.3g} prior standard deviations from its first guess {:.4g}",
                    unknown.name, estimate, unknown.unit, moved, unknown.initial);
    if (is_inconsistent(stage.consistency))
      text += fmt::format("; the mean NIS is {:.3g} (expected {:.3g}): do not trust the estimates",
                          stage.consistency.mean_nis, stage.consistency.expected_nis);
    conflicts.push_back(text +
                        fmt::format("; start again from about {:.2g}, widen its std, or set transform: log", estimate));
  }
  return conflicts;
}

}  // namespace kalfem
