// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/robust_deviations.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

/// Frequency bands of a run whose numbers agree with its model contradict each other by chance only.
void widen_by_bands(RecordEstimate& estimate) {
  if (!contradicts_itself(estimate)) return;
  const auto& history = estimate.result.unknowns_history;
  const auto innovations = sensitive_innovations(history, estimate.settled);
  if (!innovations.derivative.empty()) widen(estimate.robust, band_variances(innovations, prior_score(history)));
}

}  // namespace

bool innovations_contradict(const RecordEstimate& estimate, Index first) {
  return std::ranges::any_of(
      innovation_reasons(innovations_of(estimate.measurements, estimate.result, first)),
      [](const Reason& reason) { return reason.code.starts_with("innovation_") || reason.code.starts_with("nis_"); });
}

bool contradicts_itself(const RecordEstimate& estimate) {
  const auto& history = estimate.result.unknowns_history;
  if (!history.empty() && estimate.robust.covariance.size() > 0) {
    const auto stated = history.covariance_at(history.last());
    for (Index i = 0; i < stated.rows(); ++i)
      if (estimate.robust.covariance(i, i) > suspicious_widening * suspicious_widening * stated(i, i)) return true;
  }
  return innovations_contradict(estimate, estimate.settled);
}

InnovationRecord innovations_of(const Record& measured, const EstimationResult& result, Index first) {
  InnovationRecord record{.noise = measured.noise(),
                          .innovation = result.innovation,
                          .deviation = result.innovation_deviation,
                          .sample_rate = measured.sample_rate,
                          .start = measured.start,
                          .first = first,
                          .nis = result.nis,
                          .measured = result.measured};
  if (result.noise && result.noise->sensors_adapt) {
    const Index count = result.noise->sensors.cols() - first;
    record.noise = result.noise->sensors.rightCols(count).cwiseAbs2().rowwise().mean().cwiseSqrt();
    record.adapted_noise = true;
  }
  for (const auto& channel : measured.channels) {
    record.sensors.push_back(channel.name);
    record.units.push_back(channel.unit);
  }
  return record;
}

InnovationRecord innovations_of(const RecordEstimate& estimate) {
  return innovations_of(estimate.measurements, estimate.result, estimate.settled);
}

void set_robust_deviations(RecordEstimate& estimate) {
  const auto& history = estimate.result.unknowns_history;
  const auto& unknowns = estimate.augmented_model->options().unknowns;
  estimate.robust_deviation.setConstant(static_cast<Index>(unknowns.size()), std::numeric_limits<double>::quiet_NaN());
  if (estimate.result.failure || history.empty()) return;
  estimate.robust = robust_covariance(history);
  widen_by_bands(estimate);
  for (std::size_t i = 0; i < history.unknowns.size(); ++i) {
    const Index unknown = history.unknowns[i], place = static_cast<Index>(i);
    const auto& transform = unknowns[static_cast<std::size_t>(unknown)].transform;
    estimate.robust_deviation[unknown] =
        transform.slope(history.mean(place, history.last())) * std::sqrt(estimate.robust.covariance(place, place));
  }
}

}  // namespace kalfem
