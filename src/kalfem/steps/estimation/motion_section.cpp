// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "kalfem/page/chart_series.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/statistics/quantiles.hpp"
#include "kalfem/steps/estimation/sections.hpp"
#include "kalfem/steps/point_errors.hpp"

// Motion at points that no sensor measures, by the filter; beside the
// simulation where there is one, with the error below.

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

const PointQuantity* find_point(const std::vector<PointQuantity>& points, const std::string& name,
                                ObservedQuantity quantity) {
  const auto found =
      std::ranges::find_if(points, [&](const auto& p) { return p.point == name && p.quantity == quantity; });
  return found == points.end() ? nullptr : &*found;
}

std::vector<std::string> shown_points(const Study& study, const EstimationOutcome& outcome) {
  std::vector<std::string> names;
  names = study.report.displacements;
  if (!names.empty()) return names;
  const RestingPoints resting(outcome.points, outcome.settled);
  for (const auto& point : outcome.points)
    if (point.quantity == ObservedQuantity::displacement && names.size() < 2 && !resting.rests(point))
      names.push_back(point.point);
  return names;
}

/// Gauges that the case wants shown, or the first ones that are no sensors.
std::vector<std::string> shown_gauges(const Study& study, const EstimationOutcome& outcome) {
  if (!study.report.strains.empty()) return study.report.strains;
  const auto measured = [&](const std::string& gauge) {
    return std::ranges::any_of(study.sensors, [&](const Sensor& sensor) {
      return sensor.output.quantity == ObservedQuantity::strain && sensor.output.points.contains(gauge);
    });
  };
  std::vector<std::string> names;
  for (const auto& point : outcome.points)
    if (point.quantity == ObservedQuantity::strain && names.size() < 2 && !measured(point.point))
      names.push_back(point.point);
  return names;
}

/// What its charts are called, and its unit.
struct ShownQuantity {
  std::string word, unit;
};

ShownQuantity shown_quantity(const PointQuantity& point) {
  return {point.quantity == ObservedQuantity::strain ? "strain" : "displacement", unit_of(point.quantity)};
}

/// One quantity over time, from settling on where `zoomed`.
Chart over_time(const Study& study, const EstimationOutcome& outcome, const std::string& id, const std::string& title,
                bool zoomed) {
  const double from = outcome.measurements.time(outcome.settled);
  Chart chart{.id = id + (zoomed ? "-zoom" : ""),
              .title = title + (zoomed ? ", zoomed" : ""),
              .x_label = "time [s]",
              .x = times(outcome.measurements),
              .half_width = true};
  if (zoomed) chart.x_window = AxisRange{from, std::min(from + study.report.zoom, chart.x.back())};
  return chart;
}

Chart motion_chart(const Study& study, const EstimationOutcome& outcome, const PointQuantity& point, bool zoomed) {
  const auto [word, unit] = shown_quantity(point);
  const std::string title = word == "strain" ? "Strain at " : "Displacement of ";
  Chart chart = over_time(study, outcome, word + "-" + point.point, title + point.point, zoomed);
  chart.caption = error_words(outcome, outcome.points, point);
  chart.series = {with_band("estimate", point.mean, point.deviation, Role::estimate)};
  if (point.truth.size() > 0)
    chart.series.push_back({.label = "simulated", .y = series_values(point.truth), .role = Role::truth});
  return with_readable_ordinates(std::move(chart), word, unit);
}

/// Estimate less truth, and twice the standard deviation that the filter states about zero.
Chart error_chart(const Study& study, const EstimationOutcome& outcome, const PointQuantity& point, bool zoomed) {
  const auto [word, unit] = shown_quantity(point);
  Chart chart =
      over_time(study, outcome, "error-" + point.point, "Error of the " + word + " of " + point.point, zoomed);
  const VectorXd zero = VectorXd::Zero(point.mean.size()), twice = 2.0 * point.deviation;
  chart.series = {
      {.label = "± 2 standard deviations",
       .y = series_values(zero),
       .lower = series_values(-twice),
       .upper = series_values(twice),
       .role = Role::limit},
      {.label = "estimate less truth", .y = series_values(point.mean - point.truth), .role = Role::estimate}};
  const Index count = point.mean.size() - outcome.settled;
  const auto inside = ((point.mean - point.truth).array().abs() <= twice.array()).tail(count).count();
  chart.caption = fmt::format("After settling {} lie within ± 2 standard deviations (95.4 % expected).",
                              per_cent(static_cast<double>(inside) / static_cast<double>(count)));
  return with_readable_ordinates(std::move(chart), "error", unit);
}

void add_motion(const Study& study, const EstimationOutcome& outcome, const PointQuantity& point, Section& section) {
  const bool with_error = point.truth.size() > 0 && point.deviation.size() > 0;
  for (const bool zoomed : {false, true}) {
    if (zoomed && outcome.settled + 1 >= outcome.measurements.samples()) continue;
    section.items.emplace_back(motion_chart(study, outcome, point, zoomed));
  }
  for (const bool zoomed : {false, true}) {
    if (!with_error || (zoomed && outcome.settled + 1 >= outcome.measurements.samples())) continue;
    section.items.emplace_back(error_chart(study, outcome, point, zoomed));
  }
}

}  // namespace

std::string error_words(const EstimationOutcome& outcome, const std::vector<PointQuantity>& points,
                        const PointQuantity& point) {
  if (RestingPoints(points, outcome.settled).rests(point)) return "The simulated structure is at rest there.";
  if (!point.nrmse) return "";
  const std::string after = fmt::format(", after {} s.", four_digits(outcome.judged_from()));
  if (!point.nrmse_in_band || !outcome.band) return "NRMSE " + per_cent(*point.nrmse) + after;
  return fmt::format("NRMSE {} in the band of the excitation, {} to {} Hz; {} over the whole signal",
                     per_cent(*point.nrmse_in_band), four_digits(outcome.band->from), four_digits(outcome.band->to),
                     per_cent(*point.nrmse)) +
         after;
}

Section motion_section(const Study& study, const EstimationOutcome& outcome) {
  Section section{
      "Estimated motion", "Displacements and strains that were not measured: whole record and after settling.", {}};
  for (const auto& name : shown_points(study, outcome))
    if (const auto* point = find_point(outcome.points, name, ObservedQuantity::displacement))
      add_motion(study, outcome, *point, section);
  for (const auto& name : shown_gauges(study, outcome))
    if (const auto* point = find_point(outcome.points, name, ObservedQuantity::strain))
      add_motion(study, outcome, *point, section);
  if (auto table = error_table("NRMSE against the simulation", study, outcome.points, outcome.settled);
      !table.rows.empty())
    section.items.emplace_back(std::move(table));
  if (auto table = error_table("NRMSE of the smoothed motion", study, outcome.smoothed_points, outcome.settled);
      !table.rows.empty())
    section.items.emplace_back(std::move(table));
  return section;
}

}  // namespace kalfem
