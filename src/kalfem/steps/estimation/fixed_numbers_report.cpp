// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "kalfem/diagnosis/fixed_number_reasons.hpp"
#include "kalfem/identification/asked_numbers.hpp"
#include "kalfem/page/json_number.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/steps/estimation/report.hpp"
#include "kalfem/steps/estimation/sections.hpp"

namespace kalfem {

using Eigen::Index;
using Json = nlohmann::ordered_json;

namespace {

/// Change that a row tells of: of a number, and of a clock in sample intervals.
constexpr double in_table = 0.01, in_table_clock = 0.1;

const UnknownParameter& unknown_of(const RecordEstimate& estimate, Index j) {
  return estimate.augmented_model->options().unknowns[static_cast<std::size_t>(j)];
}

/// The change that a row tells of, in the number's scale: what is stated of it, or else 1 %, of a clock a tenth of a
/// sample interval, which a drift reaches at the end of the record.
double told_change(const RecordEstimate& estimate, const FixedNumber& number) {
  if (number.deviation > 0.0) return number.deviation;
  if (!number.is_of_clock()) return in_table;
  const auto& record = estimate.measurements;
  return in_table_clock / record.sample_rate / (number.is_drift() ? record.end() - record.start : 1.0);
}

double told_shift(const RecordEstimate& estimate, Index i) {
  return furthest_shift(estimate, i).deviations *
         told_change(estimate, estimate.fixed_numbers->numbers[static_cast<std::size_t>(i)]);
}

/// Whether the record tells a number: better than anybody guesses it, and not only because the study holds the unknowns
/// within 20 of their deviations.
bool tells(const RecordEstimate& estimate, Index i) {
  constexpr double guessed = 0.1, held = 10.0;
  const double deviation = estimate.fixed_numbers->asked_deviation[i];
  return deviation < guessed && deviation * std::abs(furthest_shift(estimate, i).deviations) < held;
}

/// Nobody doubts the rate of a clock without a cause: a drift stands in the table where it is stated, or where the
/// record asks for one.
bool is_listed(const FixedNumberStudy& study, Index i) {
  constexpr double asked_for = 3.0;
  const FixedNumber& number = study.numbers[static_cast<std::size_t>(i)];
  return !number.is_drift() || number.deviation > 0.0 ||
         std::abs(study.asked[i]) > asked_for * study.asked_deviation[i];
}

/// Stated numbers of which the record tells far more than what is stated: as unknowns they would add less.
std::string better_known(const FixedNumberStudy& study) {
  constexpr double far_better = 1.0 / 3.0;
  std::string names;
  for (Index i = 0; i < study.size(); ++i) {
    const FixedNumber& fixed = study.numbers[static_cast<std::size_t>(i)];
    const bool adds = study.considered.col(i).maxCoeff() > 0.3 * study.considered.rowwise().norm().maxCoeff();
    if (fixed.parameter && adds && study.asked_deviation[i] < far_better * fixed.deviation)
      names += (names.empty() ? "'" : ", '") + fixed.name + "'";
  }
  if (names.empty()) return "";
  return "The record tells more of " + names + " than is stated: as unknowns with these priors they would add less\n";
}

/// The stated numbers that were moved furthest, beside what is stated of them.
std::string moved_words(const FixedNumberStudy& study) {
  constexpr std::size_t most = 5;
  if (!study.is_moved()) return "";
  const auto deviations = [&](Index i) {
    const double stated = study.numbers[static_cast<std::size_t>(i)].deviation;
    return stated > 0.0 ? std::abs(study.stands_at[i]) / stated : 0.0;
  };
  std::vector<Index> order(static_cast<std::size_t>(study.size()));
  std::iota(order.begin(), order.end(), Index{0});
  std::ranges::stable_sort(order, std::ranges::greater{}, deviations);
  std::string names;
  for (std::size_t k = 0; k < most && k < order.size() && deviations(order[k]) > 0.0; ++k) {
    const FixedNumber& fixed = study.numbers[static_cast<std::size_t>(order[k])];
    names += fmt::format("{}{} {} (known to {})", k == 0 ? "" : ", ", fixed.name,
                         change_in_words(fixed, study.stands_at[order[k]]),
                         change_in_words(fixed, fixed.deviation).substr(1));
  }
  return "With the numbers as given the record contradicts the model; within what is stated of them it does not. The "
         "estimates are those with " +
         names + "; all are in sensitivity of summary.json\n";
}

}  // namespace

Json sensitivity_summary(const RecordEstimate& estimate) {
  const auto& study = *estimate.fixed_numbers;
  Json numbers = Json::array();
  for (Index i = 0; i < study.size(); ++i) {
    const FixedNumber& fixed = study.numbers[static_cast<std::size_t>(i)];
    Json shift = Json::object();
    for (Index j = 0; j < study.shift.rows(); ++j)
      shift[unknown_of(estimate, j).name] = number(study.shift(j, i) / fixed.scale);
    numbers.push_back({{"name", fixed.name},
                       {"group", group_of(fixed.kind)},
                       {"unit", fixed.unit},
                       {"value", number(fixed.value)},
                       {"known_to", fixed.deviation > 0.0 ? number(fixed.deviation * fixed.scale) : Json(nullptr)},
                       {"stands_at_change", number(study.stands_at[i] * fixed.scale)},
                       {"asked_change", number(study.asked[i] * fixed.scale)},
                       {"asked_change_std", number(study.asked_deviation[i] * fixed.scale)},
                       {"log_likelihood_gain", number(study.gain[i])},
                       {"shift", shift}});
  }
  return {{"numbers", numbers}, {"by_runs", study.by_runs}, {"not_varied", study.failed}};
}

Table sensitivity_table(const RecordEstimate& estimate, std::size_t most) {
  const auto& study = *estimate.fixed_numbers;
  std::vector<Index> order(static_cast<std::size_t>(study.size()));
  std::iota(order.begin(), order.end(), Index{0});
  std::erase_if(order, [&](Index i) { return !is_listed(study, i); });
  std::ranges::stable_sort(order, std::ranges::greater{}, [&](Index i) { return std::abs(told_shift(estimate, i)); });
  order.resize(std::min(most, order.size()));
  Table table{"Numbers that are held fixed",
              {"number", "value", "unit", "a change by", "moves", "by [std]", "the record asks for"},
              {},
              {}};
  for (const Index i : order) {
    const FixedNumber& fixed = study.numbers[static_cast<std::size_t>(i)];
    const auto furthest = furthest_shift(estimate, i);
    table.rows.push_back(
        {fixed.name, four_digits(fixed.value), fixed.unit, change_in_words(fixed, told_change(estimate, fixed)),
         unknown_of(estimate, furthest.unknown).name, fmt::format("{:+.2g}", told_shift(estimate, i)),
         tells(estimate, i) ? change_in_words(fixed, study.asked[i], study.asked_deviation[i]) : "cannot tell"});
  }
  return table;
}

std::string considered_words(const RecordEstimate& estimate) {
  if (estimate.considered_deviation.size() == 0) return "";
  const auto& study = *estimate.fixed_numbers;
  std::string words;
  const Index last = estimate.result.unknowns.deviation.cols() - 1;
  for (Index j = 0; j < study.considered.rows(); ++j) {
    Index largest = 0;
    const double most = study.considered.row(j).maxCoeff(&largest), noise = estimate.result.unknowns.deviation(j, last);
    words += fmt::format("{}: of +- {:.2g} {}, {:.2g} are noise, {:.2g} '{}'\n", unknown_of(estimate, j).name,
                         std::hypot(noise, estimate.considered_deviation[j]), unknown_of(estimate, j).unit, noise, most,
                         study.numbers[static_cast<std::size_t>(largest)].name);
  }
  return moved_words(study) + words + better_known(study);
}

Section sensitivity_section(const RecordEstimate& estimate) {
  constexpr std::size_t rows = 40;
  const bool stated = estimate.considered_deviation.size() > 0;
  return {"Numbers that are held fixed",
          std::string("What a small change of each number moves, in standard deviations of the parameter that it moves "
                      "furthest, and the change that makes the record most likely. ") +
              moved_words(*estimate.fixed_numbers) +
              (stated ? "Intervals hold what is stated by known_to; every other number is taken as exact."
                      : "They are taken as exact: the intervals do not hold what they are off by. State how well they "
                        "are known by known_to."),
          {sensitivity_table(estimate, rows)}};
}

}  // namespace kalfem
