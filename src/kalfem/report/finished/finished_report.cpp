// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/finished/finished_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "kalfem/page/display_unit.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/report/result_set.hpp"

namespace kalfem {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

std::string title_of(const std::string& step) {
  if (step == "updating") return "Updated parameters";
  return step == "posterior" ? "Posterior" : "Estimated parameters";
}

std::string filter_words(const FoundFilter& filter) {
  const auto& [mean, expected, fraction] = filter.consistency;
  std::string words;
  if (mean && expected)
    words += fmt::format("NIS {:.2f} (expected {:.2f}); {} of samples in the 95 % band\n", *mean, *expected,
                         per_cent(fraction.value_or(unknown)));
  words += fmt::format("{} states, {} steps", filter.states, filter.steps);
  if (filter.microseconds_per_step) words += fmt::format(", {:.2g} us per step", *filter.microseconds_per_step);
  if (filter.real_time_factor) words += ": " + speed_in_words(*filter.real_time_factor);
  words += fmt::format("\nFilter {}: {}\n", filter.filter, filter.reason);
  return words + fmt::format("{} substep{} per sample\n", filter.substeps, filter.substeps == 1 ? "" : "s");
}

}  // namespace

Table found_parameter_table(const FoundParameters& found) {
  Table table{
      title_of(found.by),
      {"parameter", "unit", "initial", "estimate", "95 % interval", "from", "std", "robust std", "truth", "error"},
      {},
      {}};
  for (const auto& each : found.parameters) {
    const double estimate = each.estimate.value_or(unknown), std = each.std.value_or(unknown);
    const double initial = each.initial.value_or(unknown), truth = each.truth.value_or(unknown);
    const DisplayUnit shown(each.unit, {estimate, initial, std});
    const auto& interval = each.interval;
    table.rows.push_back(
        {each.name, shown.unit(), shown.value(initial), shown.value(estimate, std),
         interval ? shown.value(interval->front(), std) + " to " + shown.value(interval->back(), std) : "-",
         !interval                                ? "-"
         : each.interval_from == "std_considered" ? "known_to"
         : each.interval_from == "std_robust"     ? "robust std"
                                                  : each.interval_from,
         shown.deviation(std), shown.deviation(each.std_robust.value_or(unknown)), shown.value(truth),
         truth == 0.0 ? "-" : per_cent(estimate / truth - 1.0)});
  }
  return without_empty_columns(std::move(table));
}

Table found_error_table(const std::string& title, const std::string& first_column, const Named<NamedErrors>& errors) {
  Table table{title, {first_column}, {}, {}};
  for (const auto& [point, own] : errors)
    for (const auto& [quantity, error] : own)
      if (std::ranges::find(table.columns, quantity) == table.columns.end()) table.columns.push_back(quantity);
  for (const auto& [point, own] : errors) {
    std::vector<std::string> row(table.columns.size());
    row.front() = point;
    for (const auto& [quantity, error] : own) {
      const auto column = std::ranges::find(table.columns, quantity) - table.columns.begin();
      row[static_cast<std::size_t>(column)] = error ? per_cent(*error) : "-";
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table found_pair_table(const std::string& comparison, const std::vector<FoundPair>& pairs) {
  Table table{"Correlation of '" + comparison + "'", {"measured [Hz]", "mode", "model [Hz]", "error", "MAC"}, {}, {}};
  for (const auto& pair : pairs)
    table.rows.push_back({four_digits(pair.measured_hz), pair.model_mode ? std::to_string(*pair.model_mode) : "-",
                          four_digits(pair.model_hz.value_or(unknown)), signed_per_cent(pair.error.value_or(unknown)),
                          pair.mac ? fmt::format("{:.3f}", *pair.mac) : "-"});
  return table;
}

Table found_timing_table(const NamedErrors& timing) {
  Table table{"Timing", {"step", "seconds"}, {}, {}};
  for (const auto& [step, seconds] : timing)
    if (seconds) table.rows.push_back({step, fmt::format("{:.2f}", *seconds)});
  return table;
}

std::string console_report(const FinishedRun& run) {
  std::string text = (run.title.empty() ? run.case_file : run.title) + "\n\n";
  const auto add = [&](const Table& table) {
    if (!table.rows.empty()) text += table.title + "\n" + to_text(table) + "\n";
  };
  for (const auto& found : run.found) add(found_parameter_table(found));
  if (run.filter) text += filter_words(*run.filter) + "\n";
  add(found_error_table("Estimated motion, NRMSE", "point", run.states));
  add(found_error_table("Motion smoothed over the whole record, NRMSE", "point", run.smoothed));
  add(found_error_table("Validation, NRMSE", "sensor", run.validation));
  add(found_error_table("Predicted motion, NRMSE", "point", run.prediction));
  for (const auto& [comparison, pairs] : run.correlation) add(found_pair_table(comparison, pairs));
  add(found_timing_table(run.timing));
  return text + "Results in " + run.folder.string() + ": " + listed(run.files) + "\n";
}

}  // namespace kalfem
