// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/finished/comparison_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "kalfem/page/display_unit.hpp"
#include "kalfem/page/json_number.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/report/finished/run_population.hpp"

namespace kalfem {
namespace {

using Json = nlohmann::ordered_json;

/// A kind of error with its title and its key in the JSON text.
struct KindOfErrors {
  const char *title, *key;
  ErrorsOfRun errors;
};
constexpr KindOfErrors kinds_of_errors[] = {{"Estimated motion, NRMSE", "states", &FinishedRun::states},
                                            {"Smoothed motion, NRMSE", "smoothed", &FinishedRun::smoothed},
                                            {"Predicted motion, NRMSE", "prediction", &FinishedRun::prediction},
                                            {"Validation, NRMSE", "validation", &FinishedRun::validation}};

double or_nan(const std::optional<double>& value) { return value.value_or(std::numeric_limits<double>::quiet_NaN()); }

std::string with_deviation(const DisplayUnit& shown, const FoundParameter& parameter) {
  const double deviation = or_nan(parameter.deviation());
  const std::string value = shown.value(or_nan(parameter.estimate), deviation);
  return std::isfinite(deviation) ? value + " ± " + shown.deviation(deviation) : value;
}

std::string interval_text(const DisplayUnit& shown, const FoundParameter& parameter) {
  if (!parameter.interval) return "-";
  const double deviation = or_nan(parameter.deviation());
  return shown.value(parameter.interval->front(), deviation) + " to " +
         shown.value(parameter.interval->back(), deviation);
}

std::string difference_text(const std::optional<double>& difference) {
  if (!difference) return "-";
  const std::string words = fmt::format("{:+.1f}", *difference);
  return words.substr(1) == "0.0" ? "0.0" : words;
}

Table parameter_comparison(const RunComparison& comparison) {
  Table table{
      "Parameters: estimate ± standard deviation, the larger of the two; differences to the first run in joint "
      "standard deviations",
      {"parameter", "unit", "truth"},
      {},
      {}};
  const bool two = comparison.runs.size() == 2;  // of more the intervals would fill the screen
  for (std::size_t i = 0; i < comparison.runs.size(); ++i) {
    table.columns.push_back(comparison.labels[i]);
    if (two) table.columns.emplace_back("95 % interval");
    if (i > 0) table.columns.emplace_back("difference");
  }
  for (const auto& parameter : compared_parameters(comparison)) {
    std::vector<double> values;
    for (const auto& run : parameter.runs)
      if (run) values.push_back(or_nan(run->estimate));
    const DisplayUnit shown(parameter.unit, values);
    std::vector<std::string> row{parameter.name, shown.unit(), shown.value(or_nan(parameter.truth))};
    for (std::size_t i = 0; i < parameter.runs.size(); ++i) {
      const auto &first = parameter.runs.front(), &run = parameter.runs[i];
      row.push_back(run ? with_deviation(shown, *run) : "-");
      if (two) row.push_back(run ? interval_text(shown, *run) : "-");
      if (i > 0) row.push_back(difference_text(first && run ? joint_deviations(*run, *first) : std::nullopt));
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table run_table(const RunComparison& comparison) {
  Table table{"Runs",
              {"run", "verdict", "filter", "states", "NIS", "expected", "in the 95 % band", "us per step", "total [s]"},
              {},
              {}};
  for (std::size_t i = 0; i < comparison.runs.size(); ++i) {
    const auto& run = comparison.runs[i];
    const FoundFilter filter = run.filter.value_or(FoundFilter{});
    table.rows.push_back(
        {comparison.labels[i], run.compared ? to_string(run.verdict) : "-", run.filter ? filter.filter : "-",
         run.filter ? std::to_string(filter.states) : "-", four_digits(or_nan(filter.consistency.mean_nis)),
         four_digits(or_nan(filter.consistency.expected_nis)), per_cent(or_nan(filter.consistency.fraction_in_95)),
         four_digits(or_nan(filter.microseconds_per_step)), four_digits(or_nan(run.timing.front().second))});
  }
  return without_empty_columns(std::move(table));
}

Table error_comparison(const std::string& title, const RunComparison& comparison, ErrorsOfRun kind) {
  Table table{title, {"quantity"}, {}, {}};
  table.columns.insert(table.columns.end(), comparison.labels.begin(), comparison.labels.end());
  for (const auto& [name, errors] : compared_errors(comparison, kind)) {
    std::vector<std::string> row{name};
    for (const auto& error : errors) row.push_back(per_cent(or_nan(error)));
    table.rows.push_back(std::move(row));
  }
  return table;
}

/// Sensors of all runs, each with what its innovations are over what they should be and how successive ones correlate.
Table sensor_comparison(const RunComparison& comparison) {
  Table table{"Sensors: innovation / expected, correlation of neighbours", {"sensor"}, {}, {}};
  table.columns.insert(table.columns.end(), comparison.labels.begin(), comparison.labels.end());
  for (std::size_t i = 0; i < comparison.runs.size(); ++i)
    for (const auto& [name, found] : comparison.runs[i].sensors) {
      auto row = std::ranges::find(table.rows, name, [](const auto& cells) { return cells.front(); });
      if (row == table.rows.end()) {
        row = table.rows.insert(table.rows.end(), std::vector<std::string>(comparison.runs.size() + 1, "-"));
        row->front() = name;
      }
      if (found.ratio)
        (*row)[i + 1] = fmt::format("{:.3g}, {}", *found.ratio,
                                    found.correlation ? fmt::format("{:.2f}", *found.correlation) : "-");
    }
  return table;
}

Table timing_comparison(const RunComparison& comparison) {
  Table table{"Time [s]", {"step"}, {}, {}};
  table.columns.insert(table.columns.end(), comparison.labels.begin(), comparison.labels.end());
  for (std::size_t i = 0; i < comparison.runs.size(); ++i)
    for (const auto& [step, seconds] : comparison.runs[i].timing) {
      auto row = std::ranges::find(table.rows, step, [](const auto& cells) { return cells.front(); });
      if (row == table.rows.end()) {
        row = table.rows.insert(table.rows.end(), std::vector<std::string>(comparison.runs.size() + 1, "-"));
        row->front() = step;
      }
      (*row)[i + 1] = !seconds ? "-" : *seconds < 0.01 ? "< 0.01" : fmt::format("{:.2f}", *seconds);
    }
  return table;
}

Json run_json(const RunComparison& comparison, std::size_t i) {
  const auto& run = comparison.runs[i];
  Json json{{"label", comparison.labels[i]},
            {"folder", run.folder.string()},
            {"run", run.identity},
            {"case", run.case_file},
            {"title", run.title},
            {"verdict", run.compared ? nlohmann::ordered_json(to_string(run.verdict)) : nlohmann::ordered_json()},
            {"message", run.message},
            {"filter", run.filter ? Json(run.filter->filter) : Json(nullptr)},
            {"nis", nullptr},
            {"sensors", Json::object()},
            {"timing", Json::object()}};
  for (const auto& [name, found] : run.sensors)
    json["sensors"][name] = {{"rms_over_expected", number(found.ratio)}, {"correlation", number(found.correlation)}};
  if (run.filter)
    json["nis"] = {{"mean", number(run.filter->consistency.mean_nis)},
                   {"expected", number(run.filter->consistency.expected_nis)},
                   {"fraction_in_95", number(run.filter->consistency.fraction_in_95)}};
  for (const auto& [step, seconds] : run.timing) json["timing"][step + "_s"] = number(seconds);
  return json;
}

Json parameter_json(const ComparedParameter& parameter) {
  Json runs = Json::array();
  const auto& first = parameter.runs.front();
  for (const auto& run : parameter.runs) {
    runs.push_back(nullptr);
    if (!run) continue;
    runs.back() = {{"estimate", number(run->estimate)},
                   {"std", number(run->std)},
                   {"std_robust", number(run->std_robust)},
                   {"interval", run->interval ? Json(*run->interval) : Json()},
                   {"difference", number(first ? joint_deviations(*run, *first) : std::nullopt)}};
  }
  return {{"unit", parameter.unit}, {"true", number(parameter.truth)}, {"runs", runs}};
}

}  // namespace

std::vector<Table> comparison_tables(const RunComparison& comparison) {
  std::vector<Table> tables{run_table(comparison), without_empty_columns(parameter_comparison(comparison))};
  for (const auto& [title, key, errors] : kinds_of_errors)
    tables.push_back(error_comparison(title, comparison, errors));
  tables.insert(tables.begin() + 2, sensor_comparison(comparison));
  tables.push_back(timing_comparison(comparison));
  if (comparison.are == RunsAre::members) {
    auto population = population_tables(comparison);
    tables.insert(tables.begin(), population.begin(), population.end());
  }
  std::erase_if(tables, [](const Table& table) { return table.rows.empty(); });
  return tables;
}

std::string comparison_text(const RunComparison& comparison) {
  std::string text;
  for (const auto& table : comparison_tables(comparison)) text += table.title + "\n" + to_text(table) + "\n";
  return comparison.differences.empty() ? text : text + comparison.differences + "\n";
}

Json comparison_json(const RunComparison& comparison) {
  Json json{{"runs", Json::array()}, {"parameters", Json::object()}};
  for (std::size_t i = 0; i < comparison.runs.size(); ++i) json["runs"].push_back(run_json(comparison, i));
  for (const auto& parameter : compared_parameters(comparison))
    json["parameters"][parameter.name] = parameter_json(parameter);
  for (const auto& [title, key, kind] : kinds_of_errors) {
    Json& errors = json[key] = Json::object();
    for (const auto& [name, values] : compared_errors(comparison, kind))
      for (const auto& value : values) errors[name].push_back(number(value));
  }
  if (comparison.are == RunsAre::members) json["population"] = population_json(comparison);
  json["differences"] = comparison.differences;
  json["warnings"] = comparison.warnings;
  return json;
}

Table verdict_table(const RunComparison& comparison) {
  Table table{"Verdicts", {"run", "verdict", "reason", "remedy"}, {}, {}};
  for (std::size_t i = 0; i < comparison.runs.size(); ++i)
    for (const auto& reason : comparison.runs[i].reasons)
      table.rows.push_back({comparison.labels[i], to_string(comparison.runs[i].verdict), reason.text, reason.remedy});
  return table;
}

}  // namespace kalfem
