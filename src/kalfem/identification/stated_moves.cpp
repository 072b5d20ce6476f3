// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/record_estimation.hpp"

#include <algorithm>

#include "kalfem/identification/robust_deviations.hpp"
#include "kalfem/statistics/quantiles.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr int first_moves = 3;     ///< with noise as the record shows it; the last of them without
constexpr int most_moves = 12;     ///< behind these
constexpr int most_halvings = 3;   ///< of one
constexpr double unlikely = 1e-3;  ///< of a distance from what is stated
constexpr double promised = 0.02;  ///< rise of the logarithm of the posterior that is not worth another move

/// An estimation with its numbers somewhere, and where the record would have them.
struct Stand {
  RecordEstimation estimation;
  FixedNumberStudy study;

  [[nodiscard]] VectorXd step() const { return study.allowed - study.stands_at; }
  [[nodiscard]] double log_posterior() const {
    return estimation.log_likelihood() - pull(study.numbers, study.stands_at);
  }
  /// By which a full step raises it, to second order.
  [[nodiscard]] double promises() const {
    const VectorXd by = step();
    return 0.5 * by.dot(study.information * by) + pull(study.numbers, by);
  }
};

std::optional<Stand> stand_of(std::optional<RecordEstimation> estimation) {
  if (!estimation) return std::nullopt;
  StepBudget unlimited;
  auto found = estimation->study_numbers(unlimited);
  if (!found) return std::nullopt;
  return Stand{*std::move(estimation), std::move(found->study)};
}

std::optional<Stand> first_stand(const RecordEstimation& held) {
  auto stand = stand_of(held.with_numbers({}, NoiseOfSensors::as_recorded));
  for (int move = 1; stand && move <= first_moves; ++move)
    stand = stand_of(held.with_numbers({stand->study.numbers, stand->study.allowed},
                                       move < first_moves ? NoiseOfSensors::as_recorded : NoiseOfSensors::stated));
  return stand;
}

/// Nothing where no part of the step is an approach.
std::optional<Stand> approach(const RecordEstimation& held, const Stand& from) {
  VectorXd step = from.step();
  for (int halving = 0; halving <= most_halvings; ++halving, step *= 0.5) {
    const ChangedNumbers changed{from.study.numbers, from.study.stands_at + step};
    auto next = held.with_numbers(changed, NoiseOfSensors::stated);
    if (next && next->log_likelihood() - pull(changed.numbers, changed.changes) > from.log_posterior())
      return stand_of(std::move(next));
  }
  return std::nullopt;
}

bool agrees(const std::optional<Stand>& stand) {
  if (!stand) return false;
  const RecordEstimate& estimate = stand->estimation.estimate();
  return !innovations_contradict(estimate, estimate.settled);
}

/// Whether the numbers lie where what is stated of them has them together; elsewhere there may be a maximum, but hardly
/// the highest.
bool is_likely(const Stand& stand) {
  const auto stated = std::ranges::count_if(stand.study.numbers, [](const auto& each) { return each.deviation > 0.0; });
  const double distance = 2.0 * pull(stand.study.numbers, stand.study.stands_at);
  return distance < chi_squared_quantile(1.0 - unlikely, static_cast<double>(stated));
}

std::optional<Stand> likelier(std::optional<Stand> one, std::optional<Stand> other) {
  if (!agrees(one) || !agrees(other)) return agrees(one) ? std::move(one) : std::move(other);
  return one->log_posterior() >= other->log_posterior() ? std::move(one) : std::move(other);
}

/// To the maximum, as far as the steps lead there.
std::optional<Stand> climbed(const RecordEstimation& held, std::optional<Stand> stand) {
  for (int move = 0; stand && move < most_moves && stand->promises() > promised; ++move) {
    auto next = approach(held, *stand);
    if (!next) break;
    stand = std::move(next);
  }
  return stand;
}

/// From where a filter that has the numbers as unknowns ends: it learns them along the record, before an oscillation
/// that they detune is out of step, where the derivatives about a run no longer tell where to go.
std::optional<Stand> learnt_stand(const RecordEstimation& held, const FixedNumberStudy& study) {
  const auto changes = held.learnt_numbers(study);
  if (!changes) return std::nullopt;
  return climbed(held, stand_of(held.with_numbers({study.numbers, *changes}, NoiseOfSensors::stated)));
}

}  // namespace

bool move_within_stated(RecordEstimation& estimation) {
  const RecordEstimate& held = estimation.estimate();
  if (held.result.failure || !(contradicts_itself(held) || held.jump)) return false;
  auto stand = climbed(estimation, first_stand(estimation));
  if (stand && !(agrees(stand) && is_likely(*stand))) {
    auto learnt = learnt_stand(estimation, stand->study);
    stand = likelier(std::move(stand), std::move(learnt));
  }
  if (!agrees(stand)) return false;
  estimation = std::move(stand->estimation);
  return true;
}

}  // namespace kalfem
