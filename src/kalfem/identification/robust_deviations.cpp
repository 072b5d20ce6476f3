// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/robust_deviations.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kalfem/identification/widening_by_chance.hpp"
#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

double widening_of(const RecordEstimate& estimate, Index place) {
  const auto& history = estimate.result.unknowns_history;
  const double stated = history.covariance_at(history.last())(place, place);
  return stated > 0.0 ? std::sqrt(estimate.robust.covariance(place, place) / stated) : 1.0;
}

/// Whether the scores widen a deviation by what matters.
bool widens(const RecordEstimate& estimate) {
  for (Index i = 0; i < estimate.robust.covariance.rows(); ++i)
    if (widening_of(estimate, i) > suspicious_widening) return true;
  return false;
}

/// Of a run whose innovations agree with the model, the stated deviation holds where chance widens it as far.
void forgive_chance(RecordEstimate& estimate) {
  if (!widens(estimate) || innovations_contradict(estimate, estimate.settled)) return;
  const auto& history = estimate.result.unknowns_history;
  const auto innovations = sensitive_innovations(history, estimate.settled);
  if (innovations.derivative.empty()) return;
  const Eigen::VectorXd chance = widening_by_chance(innovations, prior_score(history).information);
  for (Index i = 0; i < chance.size(); ++i) {
    const double found = widening_of(estimate, i);
    if (found < suspicious_widening || found > chance[i]) continue;
    estimate.robust.covariance.row(i) /= found;
    estimate.robust.covariance.col(i) /= found;
  }
}

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
  return widens(estimate) || innovations_contradict(estimate, estimate.settled);
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
  forgive_chance(estimate);
  widen_by_bands(estimate);
  for (std::size_t i = 0; i < history.unknowns.size(); ++i) {
    const Index unknown = history.unknowns[i], place = static_cast<Index>(i);
    const auto& transform = unknowns[static_cast<std::size_t>(unknown)].transform;
    estimate.robust_deviation[unknown] =
        transform.slope(history.mean(place, history.last())) * std::sqrt(estimate.robust.covariance(place, place));
  }
}

}  // namespace kalfem
