// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/prediction/section.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kalfem/page/chart_series.hpp"
#include "kalfem/steps/estimation/sections.hpp"
#include "kalfem/steps/point_errors.hpp"
#include "kalfem/steps/prediction/outcome.hpp"
#include "kalfem/study/structural_modifications.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

/// Empty beyond the last mode.
std::string predicted_frequency(const StructuralModificationResult& modification, Index mode) {
  if (mode >= modification.frequencies.size()) return "";
  std::string frequency = fmt::format("{:.2f}", modification.frequencies[mode]);
  if (modification.deviations.size() == 0) return frequency;
  const double deviation = modification.deviations[mode];
  return frequency + (std::isfinite(deviation) ? fmt::format(" +- {:.2f}", deviation) : " +- ?");
}

}  // namespace

Section prediction_section(const Study& study, const EstimationOutcome& estimation, const PredictionOutcome& outcome) {
  Section section{"Prediction of '" + outcome.substructure + "'",
                  "The linear substructure alone, driven by its estimated boundary accelerations.",
                  {}};
  const double from = estimation.measurements.time(estimation.settled);
  const RestingPoints resting(outcome.points, estimation.settled);
  int drawn = 0;
  for (const auto& point : outcome.points) {
    const bool of_interest = point.quantity == ObservedQuantity::acceleration && shown(study, point);
    if (!of_interest || resting.rests(point) || drawn == 4) continue;
    ++drawn;
    Chart chart{.id = "prediction-" + point.point,
                .title = "Acceleration of " + point.point,
                .x_label = "time [s]",
                .y_label = "acceleration [m/s^2]",
                .x = times(estimation.measurements),
                .series = {{.label = "predicted", .y = series_values(point.mean), .role = Role::predicted}},
                .half_width = true};
    if (point.truth.size() > 0)
      chart.series.push_back({.label = "simulated", .y = series_values(point.truth), .role = Role::truth});
    chart.caption = error_words(estimation, outcome.points, point);
    if (from < chart.x.back()) chart.x_window = AxisRange{from, std::min(from + study.report.zoom, chart.x.back())};
    section.items.emplace_back(std::move(chart));
  }
  if (auto table =
          error_table("NRMSE against the simulation of the whole structure", study, outcome.points, estimation.settled);
      !table.rows.empty())
    section.items.emplace_back(std::move(table));
  return section;
}

Table modification_table(const std::vector<StructuralModificationResult>& modifications) {
  Table table{"Natural frequencies of modifications [Hz]", {"mode"}, {}, {}};
  Index longest = 0;
  for (const auto& each : modifications) {
    table.columns.push_back(each.name);
    longest = std::max(longest, each.frequencies.size());
  }
  for (Index i = 0; i < longest; ++i) {
    table.rows.push_back({std::to_string(i + 1)});
    for (const auto& each : modifications) table.rows.back().push_back(predicted_frequency(each, i));
  }
  return table;
}

}  // namespace kalfem
