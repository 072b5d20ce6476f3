// SPDX-License-Identifier: Apache-2.0
#include "kalfem/diagnosis/fixed_number_reasons.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "kalfem/identification/asked_numbers.hpp"
#include "kalfem/identification/freed_numbers.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

constexpr std::size_t most_named = 4;

std::string also_likely(const FixedNumberStudy& study, const std::vector<Index>& asked) {
  std::string names;
  for (std::size_t k = 1; k < asked.size() && k < most_named; ++k)
    if (study.gain[asked[k]] > study.gain[asked.front()] - as_likely)
      names +=
          (names.empty() ? "; as likely: '" : ", '") + study.numbers[static_cast<std::size_t>(asked[k])].name + "'";
  return names;
}

const TriedNumber* trial_of(const RecordEstimate& estimate, const FixedNumber& number) {
  if (!estimate.freed) return nullptr;
  const auto& tried = estimate.freed->tried;
  const auto found = std::ranges::find(tried, name_as_unknown(number), &TriedNumber::name);
  return found == tried.end() ? nullptr : &*found;
}

/// What a trial as an unknown said; otherwise whether there may be one.
std::string to_estimate(const RecordEstimate& estimate, const FixedNumber& number) {
  const auto* trial = trial_of(estimate, number);
  if (trial && !trial->kept)
    return fmt::format(
        "check it (as an unknown it does not predict the last third of the record better: "
        "log-likelihood {:+.2g}); or ",
        trial->predicted);
  if (!estimate.freed || estimate.freed->how == FreeNumbers::none) return "check it; or ";
  if (!can_be_freed(number)) return "check its calibration; or ";
  const std::string better =
      trial
          ? fmt::format(" (it predicts the last third of the record better: log-likelihood {:+.3g})", trial->predicted)
          : "";
  return "estimate it: add '" + name_as_unknown(number) + "' to estimate.unknown" + better + "; or ";
}

/// Unit in which a change is told, and how many of it the number's scale has.
std::pair<double, std::string> told_in(const FixedNumber& number) {
  if (number.is_delay()) return {1e3, "ms"};
  if (number.is_drift()) return {1e6, "ppm"};
  return number.value == 0.0 ? std::pair(number.scale, number.unit) : std::pair(100.0, std::string("%"));
}

std::string remedy_for(const RecordEstimate& estimate, const FixedNumber& number, double asked) {
  const auto [factor, unit] = number.is_of_clock() ? told_in(number) : std::pair(100.0, std::string("%"));
  const double stated = std::max(factor * std::abs(asked), 1e-4);
  return to_estimate(estimate, number) +
         fmt::format("state how well it is known, known_to: {{{}: {:.1g} {}}}", number.name, stated, unit);
}

}  // namespace

std::string change_in_words(const FixedNumber& number, double change, std::optional<double> deviation) {
  const auto [factor, unit] = told_in(number);
  const std::string changed = fmt::format("{:+.3g} {}", factor * change, unit);
  return deviation ? fmt::format("{} +- {:.2g} {}", changed, factor * *deviation, unit) : changed;
}

std::vector<Reason> fixed_number_reasons(const RecordEstimate& estimate) {
  if (!estimate.fixed_numbers) return {};
  const auto& study = *estimate.fixed_numbers;
  const std::vector<Index> asked = asked_numbers(estimate);
  if (asked.empty() || !may_be_all_that_is_wrong(estimate, asked.front())) return {};
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
           .remedy = remedy_for(estimate, number, study.asked[i]),
           .weight = std::numeric_limits<double>::infinity()}};
}

}  // namespace kalfem
