// SPDX-License-Identifier: Apache-2.0
#include "kalfem/diagnosis/fixed_number_reasons.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "kalfem/identification/robust_deviations.hpp"
#include "kalfem/identification/stated_interval.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

constexpr double matters = 1.0;    ///< standard deviations of an unknown
constexpr double as_likely = 3.0;  ///< log-likelihood by which explanations are told apart
constexpr double part_of_substep = 0.5;
constexpr double small_change = 0.1;  ///< of a number, in its scale
constexpr double explained = 1.2;     ///< mean NIS over what is expected
constexpr std::size_t most_named = 4;

/// Half the width of the 95 % interval over 1.96, of the parameter.
double interval_deviation(const RecordEstimate& estimate, Index unknown) {
  const auto interval = stated_interval(estimate, unknown);
  return (interval.upper - interval.lower) / (2.0 * 1.96);
}

/// Whether a run with the change found at least half of the rise of ln L that its linear prediction promises.
bool is_confirmed(const FixedNumberStudy& study, Index i) {
  return study.any_stated() || study.confirmed[i] > 0.5 * study.gain[i];
}

/// Connector forces that are polynomials over a substep act like a delay of a part of it.
bool is_beyond_the_step(const RecordEstimate& estimate, Index i) {
  const double substep = 1.0 / (estimate.measurements.sample_rate * estimate.substeps.substeps);
  return !estimate.fixed_numbers->numbers[static_cast<std::size_t>(i)].is_delay() ||
         std::abs(estimate.fixed_numbers->asked[i]) > part_of_substep * substep;
}

bool moves_an_unknown(const RecordEstimate& estimate, Index i) {
  return std::abs(furthest_shift(estimate, i).deviations * estimate.fixed_numbers->asked[i]) > matters;
}

/// Whether the innovations agree with the model once number `i` is changed by little: each unit of log-likelihood takes
/// two off the sum of NIS. A large change may stand for another mistake, such as a unit.
bool explains(const RecordEstimate& estimate, Index i) {
  if (std::abs(estimate.fixed_numbers->asked[i]) > small_change) return false;
  const auto& found = estimate.consistency;
  const auto samples = static_cast<double>(estimate.measurements.samples() - estimate.settled);
  return found.mean_nis - 2.0 * estimate.fixed_numbers->gain[i] / samples < explained * found.expected_nis;
}

/// The numbers whose change the record asks for, the likeliest first.
std::vector<Index> asked_for(const RecordEstimate& estimate) {
  const auto& study = *estimate.fixed_numbers;
  std::vector<Index> asked;
  for (Index i = 0; i < study.size(); ++i)
    if (study.is_significant(i) && is_confirmed(study, i) && is_beyond_the_step(estimate, i) &&
        moves_an_unknown(estimate, i))
      asked.push_back(i);
  std::ranges::stable_sort(asked, std::ranges::greater{}, [&](Index i) { return study.gain[i]; });
  return asked;
}

std::string also_likely(const FixedNumberStudy& study, const std::vector<Index>& asked) {
  std::string names;
  for (std::size_t k = 1; k < asked.size() && k < most_named; ++k)
    if (study.gain[asked[k]] > study.gain[asked.front()] - as_likely)
      names +=
          (names.empty() ? "; as likely: '" : ", '") + study.numbers[static_cast<std::size_t>(asked[k])].name + "'";
  return names;
}

std::string name_as_unknown(const FixedNumber& number) {
  return number.kind == FixedNumberKind::gain ? "sensors." + number.name : number.name;
}

std::string remedy_for(const FixedNumber& number, double asked) {
  const bool may_be_unknown = number.parameter.has_value() || number.kind == FixedNumberKind::gain;
  const double stated = std::max(std::abs(asked), 1e-6);
  const std::string known =
      fmt::format("state how well it is known, known_to: {{{}: {}}}", number.name,
                  number.is_delay() ? fmt::format("{:.1g} ms", 1e3 * stated) : fmt::format("{:.1g} %", 100.0 * stated));
  return (may_be_unknown ? "estimate it: add '" + name_as_unknown(number) + "' to estimate.unknown; or "
                         : "check its calibration; or ") +
         known;
}

}  // namespace

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

std::string change_in_words(const FixedNumber& number, double change, std::optional<double> deviation) {
  const double factor = number.is_delay() ? 1e3 : number.value == 0.0 ? number.scale : 100.0;
  const std::string unit = number.is_delay() ? "ms" : number.value == 0.0 ? number.unit : "%";
  const std::string changed = fmt::format("{:+.3g} {}", factor * change, unit);
  return deviation ? fmt::format("{} +- {:.2g} {}", changed, factor * *deviation, unit) : changed;
}

std::vector<Reason> fixed_number_reasons(const RecordEstimate& estimate) {
  if (!estimate.fixed_numbers) return {};
  const auto& study = *estimate.fixed_numbers;
  const std::vector<Index> asked = asked_for(estimate);
  if (asked.empty()) return {};
  if (innovations_contradict(estimate, estimate.settled) && !explains(estimate, asked.front())) return {};
  const Index i = asked.front();
  const FixedNumber& number = study.numbers[static_cast<std::size_t>(i)];
  const auto [unknown, deviations] = furthest_shift(estimate, i);
  const std::string& moved = estimate.augmented_model->options().unknowns[static_cast<std::size_t>(unknown)].name;
  const std::string stated = number.deviation > 0.0 ? fmt::format(", which is known to {}",
                                                                  change_in_words(number, number.deviation).substr(1))
                                                    : "";
  return {{.code = "fixed_parameter",
           .subject = number.name,
           .text = fmt::format("the record asks for another '{}'{}: {}, which moves '{}' by {:.2g} of its standard "
                               "deviations (log-likelihood {:+.3g}){}",
                               number.name, stated, change_in_words(number, study.asked[i], study.asked_deviation[i]),
                               moved, std::abs(deviations * study.asked[i]), study.gain[i], also_likely(study, asked)),
           .remedy = remedy_for(number, study.asked[i]),
           .weight = std::numeric_limits<double>::infinity()}};
}

}  // namespace kalfem
