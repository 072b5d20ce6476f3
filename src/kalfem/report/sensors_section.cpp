#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kalfem/report/sections.hpp"
#include "kalfem/report/tables.hpp"
#include "kalfem/statistics/quantiles.hpp"

// What each sensor measured, what the filter expected before it saw it, and whether the difference is white noise.

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr Index lags = 40;
/// Of neighbours: deviations widen by sqrt((1 + r) / (1 - r)), which the verdict calls suspicious from here on.
constexpr double relevant_correlation =
    (suspicious_widening * suspicious_widening - 1.0) / (suspicious_widening * suspicious_widening + 1.0);

/// The filter's innovations of one sensor.
struct SensorCourse {
  SensorCourse(const EstimationOutcome& outcome, Index row)
      : name(outcome.measurements.channels[static_cast<std::size_t>(row)].name),
        unit(outcome.measurements.channels[static_cast<std::size_t>(row)].unit),
        measured(outcome.measurements.values.row(row).transpose()),
        innovation(outcome.result.innovation.row(row).transpose()),
        deviation(outcome.result.innovation_deviation.row(row).transpose()) {
    const Index from = std::min(outcome.settled, innovation.size() - 1);
    settled = innovation.cwiseQuotient(deviation).tail(innovation.size() - from);
  }

  std::string name, unit;
  VectorXd measured, innovation, deviation;
  VectorXd settled;  ///< innovations after settling, in their expected deviations
};

Chart course_chart(const EstimationOutcome& outcome, const SensorCourse& sensor, double zoom) {
  const double from = outcome.measurements.time(outcome.settled);
  Chart chart{.id = "sensor-" + sensor.name,
              .title = sensor.name,
              .caption = "Expected: one sample ahead, with the 95 % band of what the sensor would show.",
              .x_label = "time [s]",
              .y_label = "[" + sensor.unit + "]",
              .x = times(outcome.measurements),
              .series = {{.label = "measured", .y = series_values(sensor.measured), .role = Role::measured},
                         with_band("expected", sensor.measured - sensor.innovation, sensor.deviation, Role::estimate)},
              .half_width = true};
  if (from < chart.x.back()) chart.x_window = AxisRange{from, std::min(from + zoom, chart.x.back())};
  return chart;
}

Chart innovation_chart(const EstimationOutcome& outcome, const SensorCourse& sensor, double innovation_to_noise) {
  const VectorXd zero = VectorXd::Zero(sensor.innovation.size());
  return {
      .id = "innovation-" + sensor.name,
      .title = "Innovation of " + sensor.name,
      .caption = std::isfinite(innovation_to_noise) ? fmt::format("RMS / noise = {:.3f}.", innovation_to_noise) : "",
      .x_label = "time [s]",
      .y_label = "innovation [" + sensor.unit + "]",
      .x = times(outcome.measurements),
      .series = {{.label = "innovation", .y = series_values(sensor.innovation), .role = Role::measured},
                 with_band("expected 95 %", zero, sensor.deviation, Role::limit)},
      .half_width = true};
}

/// Over the pairs of samples that are both there; empty where there are too few.
std::vector<double> correlogram(const VectorXd& sequence) {
  std::vector<double> values;
  const auto known = sequence.array().isFinite();
  if (known.count() < 4 * lags) return values;
  const VectorXd filled = known.select(sequence.array(), 0.0);
  for (Index lag = 0; lag <= lags; ++lag)
    values.push_back(filled.head(filled.size() - lag).dot(filled.tail(filled.size() - lag)) / filled.squaredNorm());
  return values;
}

Chart correlation_chart(const SensorCourse& sensor, const std::vector<double>& values) {
  const double significant = 1.96 / std::sqrt(static_cast<double>(sensor.settled.array().isFinite().count()));
  Chart chart{
      .id = "correlation-" + sensor.name,
      .title = "Autocorrelation of the innovations of " + sensor.name,
      .caption = fmt::format("White innovations stay within ±{:.3f} at 95 % of the lags; neighbours above {:.2f} "
                             "make the deviations of parameters more than {} times too small.",
                             significant, relevant_correlation, suspicious_widening),
      .x_label = "lag [samples]",
      .y_label = "correlation [-]",
      .y_window = AxisRange{-1.0, 1.0},
      .half_width = true};
  for (std::size_t lag = 1; lag < values.size(); ++lag) chart.x.push_back(static_cast<double>(lag));
  const auto level = [&](double value) { return std::vector<double>(chart.x.size(), value); };
  chart.series = {{.label = "innovations", .y = {values.begin() + 1, values.end()}, .role = Role::estimate},
                  {.label = "significant",
                   .y = level(0.0),
                   .lower = level(-significant),
                   .upper = level(significant),
                   .role = Role::limit},
                  {.label = "relevant", .y = level(relevant_correlation), .role = Role::predicted}};
  return chart;
}

std::vector<std::string> table_row(const SensorCourse& sensor, const std::vector<double>& correlation,
                                   double innovation_to_noise) {
  const auto known = sensor.settled.array().isFinite();
  const double count = static_cast<double>(known.count());
  if (count == 0.0) return {sensor.name, "0", "-", "-", "-", "-"};
  const double size = std::sqrt(known.select(sensor.settled.array().square(), 0.0).sum() / count);
  const auto inside = (sensor.settled.array().abs() < normal_quantile(0.975)).count();
  return {sensor.name,
          std::to_string(known.count()),
          four_digits(size),
          per_cent(static_cast<double>(inside) / count),
          correlation.size() > 1 ? fmt::format("{:.2f}", correlation[1]) : "-",
          std::isfinite(innovation_to_noise) ? four_digits(innovation_to_noise) : "-"};
}

}  // namespace

Section sensors_section(const Study& study, const EstimationOutcome& outcome) {
  Section section{"Sensors",
                  "What each sensor measured and what the filter expected of it, one sample ahead. The difference, the "
                  "innovation, is white and as large as expected where model, noise and parameters are right.",
                  {}};
  Table table{"After settling",
              {"sensor", "samples", "innovation / expected", "in the 95 % band", "correlation of neighbours",
               "innovation / noise"},
              {},
              {}};
  std::vector<Chart> charts;
  for (Index row = 0; row < outcome.result.innovation.rows(); ++row) {
    if (outcome.result.innovation.row(row).array().isNaN().all()) continue;
    const SensorCourse sensor(outcome, row);
    const auto correlation = correlogram(sensor.settled);
    const double to_noise = outcome.consistency.innovation_to_noise[row];
    table.rows.push_back(table_row(sensor, correlation, to_noise));
    charts.push_back(course_chart(outcome, sensor, study.report.zoom));
    charts.push_back(innovation_chart(outcome, sensor, to_noise));
    if (!correlation.empty()) charts.push_back(correlation_chart(sensor, correlation));
  }
  section.items.emplace_back(std::move(table));
  for (auto& chart : charts) section.items.emplace_back(std::move(chart));
  return section;
}

}  // namespace kalfem
