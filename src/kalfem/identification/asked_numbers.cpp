// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/asked_numbers.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/identification/robust_deviations.hpp"
#include "kalfem/identification/stated_interval.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

constexpr double matters = 1.0;  ///< standard deviations of an unknown
constexpr double part_of_substep = 0.5;
constexpr double small_change = 0.1;  ///< of a number, in its scale
constexpr double explained = 1.2;     ///< mean NIS over what is expected

/// Whether a run with the change found at least half of the rise of ln L that its linear prediction promises.
bool is_confirmed(const FixedNumberStudy& study, Index i) { return study.confirmed[i] > 0.5 * study.promised_rise(i); }

/// Connector forces that are polynomials over a substep act like a delay of a part of it.
bool is_beyond_the_step(const RecordEstimate& estimate, Index i) {
  const auto& record = estimate.measurements;
  const auto& number = estimate.fixed_numbers->numbers[static_cast<std::size_t>(i)];
  const double substep = 1.0 / (record.sample_rate * estimate.substeps.substeps);
  const double late =
      std::abs(estimate.fixed_numbers->asked[i]) * (number.is_drift() ? record.end() - record.start : 1.0);
  return !number.is_of_clock() || late > part_of_substep * substep;
}

bool moves_an_unknown(const RecordEstimate& estimate, Index i) {
  return std::abs(furthest_shift(estimate, i).deviations * estimate.fixed_numbers->asked[i]) > matters;
}

}  // namespace

double interval_deviation(const RecordEstimate& estimate, Index unknown) {
  const auto interval = stated_interval(estimate, unknown);
  return (interval.upper - interval.lower) / (2.0 * 1.96);
}

FurthestShift furthest_shift(const RecordEstimate& estimate, Index i) {
  FurthestShift furthest;
  const auto shift = estimate.fixed_numbers->shift.col(i);
  for (Index j = 0; j < shift.size(); ++j) {
    const double deviation = interval_deviation(estimate, j);
    const double deviations = deviation > 0.0 ? shift[j] / deviation : 0.0;
    if (std::abs(deviations) > std::abs(furthest.deviations)) furthest = {j, deviations};
  }
  return furthest;
}

std::vector<Index> asked_numbers(const RecordEstimate& estimate) {
  std::vector<Index> asked;
  if (!estimate.fixed_numbers) return asked;
  const auto& study = *estimate.fixed_numbers;
  for (Index i = 0; i < study.size(); ++i)
    if (study.is_significant(i) && is_confirmed(study, i) && is_beyond_the_step(estimate, i)) asked.push_back(i);
  if (std::ranges::none_of(asked, [&](Index i) { return moves_an_unknown(estimate, i); })) return {};
  std::ranges::stable_sort(asked, std::ranges::greater{}, [&](Index i) { return study.gain[i]; });
  return asked;
}

bool may_be_all_that_is_wrong(const RecordEstimate& estimate, Index i) {
  if (!innovations_contradict(estimate, estimate.settled)) return true;
  if (std::abs(estimate.fixed_numbers->asked[i]) > small_change) return false;
  const auto& found = estimate.consistency;
  const auto samples = static_cast<double>(estimate.measurements.samples() - estimate.settled);
  const double unit_of_nis = 2.0 / samples;  // of the mean, for each unit of log-likelihood
  return found.mean_nis - unit_of_nis * estimate.fixed_numbers->gain[i] < explained * found.expected_nis;
}

}  // namespace kalfem
