// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include <fmt/format.h>

#include "kalfem/identification/freed_numbers.hpp"
#include "kalfem/page/json_number.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/steps/estimation/report.hpp"
#include "kalfem/steps/estimation/sections.hpp"

namespace kalfem {

using Json = nlohmann::ordered_json;

namespace {

const char* fate_of(const TriedNumber& tried, const FreedNumbers& freed) {
  return !tried.kept ? "stays fixed" : freed.taken ? "is an unknown now" : "is better estimated";
}

std::string with_unit(double value, const std::string& unit) {
  return four_digits(value) + (unit == "-" ? "" : " " + unit);
}

}  // namespace

Json freed_summary(const FreedNumbers& freed) {
  Json tried = Json::array(), moved = Json::array();
  for (const auto& each : freed.tried)
    tried.push_back({{"name", each.name},
                     {"unit", each.number.unit},
                     {"held", number(each.number.value)},
                     {"prior_std", number(each.prior)},
                     {"value", number(each.value)},
                     {"std", number(each.deviation)},
                     {"predicted_gain", number(each.predicted)},
                     {"kept", each.kept}});
  for (const auto& each : freed.moved)
    moved.push_back({{"parameter", each.name},
                     {"unit", each.unit},
                     {"before", number(each.before)},
                     {"after", number(each.after)},
                     {"deviations", number(each.deviations)}});
  return {{"how", to_string(freed.how)}, {"tried", tried}, {"moved", moved}};
}

std::string freed_words(const FreedNumbers& freed) {
  std::string words;
  for (const auto& each : freed.tried)
    words +=
        fmt::format("'{}' {}: as an unknown it predicts the last third of the record {} (log-likelihood {:+.3g})\n",
                    each.name, fate_of(each, freed), each.kept ? "better" : "no better", each.predicted);
  for (const auto& each : freed.moved)
    words += fmt::format("  that {} '{}' from {} to {}, by {:.2g} of its standard deviations\n",
                         freed.taken ? "moved" : "moves", each.name, four_digits(each.before),
                         with_unit(each.after, each.unit), std::abs(each.deviations));
  return words.empty() ? "" : words + "\n";
}

Section freed_section(const FreedNumbers& freed) {
  Table tried{"Fixed numbers tried as unknowns",
              {"number", "held at", "found", "std", "unit", "log-likelihood of the last third", "then"},
              {},
              {}};
  for (const auto& each : freed.tried)
    tried.rows.push_back({each.name, four_digits(each.number.value), four_digits(each.value),
                          fmt::format("{:.2g}", each.deviation), each.number.unit,
                          fmt::format("{:+.3g}", each.predicted), fate_of(each, freed)});
  Table moved{"What that moves", {"parameter", "before", "after", "unit", "by [std]"}, {}, {}};
  for (const auto& each : freed.moved)
    moved.rows.push_back({each.name, four_digits(each.before), four_digits(each.after), each.unit,
                          fmt::format("{:+.2g}", each.deviations)});
  Section section{"Numbers that the record asks to change",
                  "Each was tried as an unknown: it is one where the last third of the record, predicted sample by "
                  "sample from what is before, becomes far likelier.",
                  {std::move(tried)}};
  if (!moved.rows.empty()) section.items.emplace_back(std::move(moved));
  return section;
}

}  // namespace kalfem
