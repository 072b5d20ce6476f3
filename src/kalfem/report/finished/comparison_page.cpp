// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/finished/comparison_report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "kalfem/page/chart_series.hpp"
#include "kalfem/report/finished/run_series.hpp"

namespace kalfem {
namespace {

using Eigen::VectorXd;

constexpr std::size_t grid_points = 2000;  ///< of a chart with several runs
constexpr std::size_t most_with_bands = 3;

/// Values at other abscissae: straight lines between the samples, nothing outside.
std::vector<double> interpolated(const VectorXd& x, const VectorXd& y, const std::vector<double>& at) {
  std::vector<double> values;
  for (const double where : at) {
    const auto next = std::ranges::lower_bound(x, where) - x.begin();
    if (next == x.size() || (next == 0 && where < x[0]))
      values.push_back(std::numeric_limits<double>::quiet_NaN());
    else if (next == 0)
      values.push_back(y[0]);
    else
      values.push_back(y[next - 1] + (y[next] - y[next - 1]) * (where - x[next - 1]) / (x[next] - x[next - 1]));
  }
  return values;
}

/// One parameter in all runs that followed it: over time by the filter, or over the iterations of the updating.
std::optional<Chart> course_chart(const RunComparison& comparison, const std::vector<RunSeries>& series,
                                  const ComparedParameter& parameter, bool of_filter) {
  Chart chart{.title = parameter.name, .x_label = of_filter ? "time [s]" : "evaluation", .half_width = true};
  struct Course {
    std::size_t run;
    ParameterCourse values;
  };
  std::vector<Course> courses;
  for (std::size_t i = 0; i < series.size(); ++i)
    if (auto found = of_filter ? series[i].filter_course(parameter.name) : series[i].updating_course(parameter.name))
      courses.push_back({i, std::move(*found)});
  if (courses.empty()) return std::nullopt;
  double from = std::numeric_limits<double>::infinity(), to = -from;
  for (const auto& [run, values] : courses) {
    from = std::min(from, values.x[0]);
    to = std::max(to, values.x[values.x.size() - 1]);
  }
  if (!(from < to)) return std::nullopt;
  for (std::size_t k = 0; k < grid_points; ++k)
    chart.x.push_back(from + (to - from) * static_cast<double>(k) / static_cast<double>(grid_points - 1));
  chart.x.back() = to;
  for (const auto& [run, values] : courses) {
    Series curve{.label = comparison.labels[run], .y = interpolated(values.x, values.mean, chart.x)};
    if (values.lower.size() > 0 && courses.size() <= most_with_bands) {
      curve.lower = interpolated(values.x, values.lower, chart.x);
      curve.upper = interpolated(values.x, values.upper, chart.x);
    }
    chart.series.push_back(std::move(curve));
  }
  if (parameter.truth)
    chart.series.push_back(
        {.label = "truth", .y = std::vector<double>(chart.x.size(), *parameter.truth), .role = Role::truth});
  return with_readable_ordinates(std::move(chart), parameter.name, parameter.unit);
}

/// "suspension" of "/law/suspension/force", the connectors whose laws some run holds.
std::vector<std::string> connectors_with_laws(const std::vector<RunSeries>& series) {
  constexpr std::string_view begin = "/law/", end = "/force";
  std::vector<std::string> names;
  for (const auto& run : series)
    for (const auto& path : run.below("/law")) {
      if (!path.ends_with(end)) continue;
      auto name = path.substr(begin.size(), path.size() - begin.size() - end.size());
      if (std::ranges::find(names, name) == names.end()) names.push_back(std::move(name));
    }
  return names;
}

/// The law of one connector in every run that identified it, each with its 95 % band and over the part of the abscissa
/// where its own data were.
std::optional<Chart> law_chart(const RunComparison& comparison, const std::vector<RunSeries>& series,
                               const std::string& connector, bool over_rate) {
  const std::string group = "/law/" + connector + "/", over = over_rate ? "rate" : "deformation";
  Chart chart{.id = "law-" + connector,
              .title = connector + ": force over " + (over_rate ? "velocity" : "deformation"),
              .caption = "The laws as they were identified, with their 95 % bands, each where its data were.",
              .scatter = true};
  for (std::size_t i = 0; i < series.size(); ++i) {
    const auto x = series[i].read(group + over), force = series[i].read(group + "force");
    const auto deviation = series[i].read(group + "force_std");
    if (!x || !force || x->size() != force->size()) continue;
    Series curve = with_band(comparison.labels[i], *force, deviation.value_or(VectorXd()), Role::other);
    curve.x = series_values(*x);
    chart.series.push_back(std::move(curve));
  }
  if (chart.series.empty()) return std::nullopt;
  return with_readable_abscissae(with_readable_ordinates(std::move(chart), "force", "N"),
                                 over_rate ? "velocity" : "deformation", over_rate ? "m/s" : "m");
}

Section laws_section(const RunComparison& comparison, const std::vector<RunSeries>& series) {
  Section section{"Laws", "", {}};
  for (const auto& connector : connectors_with_laws(series))
    for (const bool over_rate : {true, false})
      if (auto chart = law_chart(comparison, series, connector, over_rate)) {
        section.items.emplace_back(std::move(*chart));
        break;
      }
  return section;
}

Section courses_section(const RunComparison& comparison, const std::vector<RunSeries>& series) {
  Section section{
      "Courses of the parameters", "Estimates with their 95 % bands, where three runs or fewer are shown.", {}};
  for (const auto& parameter : compared_parameters(comparison))
    for (const bool of_filter : {true, false})
      if (auto chart = course_chart(comparison, series, parameter, of_filter))
        section.items.emplace_back(std::move(*chart));
  return section;
}

}  // namespace

Page comparison_page(const RunComparison& comparison) {
  Page page{.title = "Runs compared", .subtitle = fmt::format("{}", fmt::join(comparison.labels, ", "))};
  for (const auto& run : comparison.runs)
    if (run.compared) page.status = std::max(page.status, std::optional(run.verdict));
  page.summary = comparison.differences;
  for (const auto& warning : comparison.warnings) page.summary += " Warning: " + warning + ".";
  Section tables{"Numbers", "", {}};
  for (auto& table : comparison_tables(comparison)) tables.items.emplace_back(std::move(table));
  if (auto verdicts = verdict_table(comparison); !verdicts.rows.empty()) tables.items.emplace_back(std::move(verdicts));
  page.sections.push_back(std::move(tables));
  std::vector<RunSeries> series;
  for (const auto& run : comparison.runs) series.emplace_back(run);
  if (auto laws = laws_section(comparison, series); !laws.items.empty()) page.sections.push_back(std::move(laws));
  if (auto courses = courses_section(comparison, series); !courses.items.empty())
    page.sections.push_back(std::move(courses));
  return page;
}

}  // namespace kalfem
