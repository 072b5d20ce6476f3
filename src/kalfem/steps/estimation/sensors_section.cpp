// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "kalfem/page/chart_series.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/records/spectrum_pair.hpp"
#include "kalfem/statistics/quantiles.hpp"
#include "kalfem/steps/estimation/sections.hpp"
#include "kalfem/steps/estimation/sensor_course.hpp"

// What each sensor measured, what the filter expected before it saw it, and whether the difference is white noise.
// First a table with a line a sensor, then for each its course, and folded away behind it how its innovations look over
// frequency, over lags, against the excitations, and by their distribution.

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr Index lags = 40;
/// Of neighbours: deviations widen by sqrt((1 + r) / (1 - r)), which the verdict calls suspicious from here on.
constexpr double relevant_correlation =
    (suspicious_widening * suspicious_widening - 1.0) / (suspicious_widening * suspicious_widening + 1.0);

std::string fold_of(const SensorCourse& sensor) {
  return "Spectra, coherence, correlations and distribution of " + sensor.name;
}

Chart course_chart(const EstimationOutcome& outcome, const SensorCourse& sensor, double zoom) {
  const double from = sensor.settled_at;
  Chart chart{.id = "sensor-" + sensor.name,
              .title = sensor.name,
              .caption = "Expected: one sample ahead, with the 95 % band of what the sensor would show.",
              .x_label = "time [s]",
              .y_label = "[" + sensor.unit + "]",
              .x = times(outcome.measurements),
              .series = {{.label = "measured", .y = series_values(sensor.measured), .role = Role::measured},
                         with_band("expected", sensor.expected, sensor.deviation, Role::estimate)},
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

/// Values of lags `first`, `first` + 1, ... with the level beyond which chance does not explain one.
Chart lag_chart(const SensorCourse& sensor, std::vector<double> values, double first) {
  const double significant = 1.96 / std::sqrt(static_cast<double>(sensor.known));
  Chart chart{.x_label = "lag [samples]",
              .y_label = "correlation [-]",
              .y_window = AxisRange{-1.0, 1.0},
              .half_width = true,
              .fold = fold_of(sensor)};
  chart.x.resize(values.size());
  std::iota(chart.x.begin(), chart.x.end(), first);
  const auto level = [&](double value) { return std::vector<double>(values.size(), value); };
  chart.series = {{.label = "significant",
                   .y = level(0.0),
                   .lower = level(-significant),
                   .upper = level(significant),
                   .role = Role::limit},
                  {.label = "innovations", .y = std::move(values), .role = Role::estimate}};
  chart.caption = fmt::format("White innovations stay within ±{:.3f} at 95 % of the lags", significant);
  return chart;
}

Chart autocorrelation_chart(const SensorCourse& sensor, const std::vector<double>& values) {
  Chart chart = lag_chart(sensor, {values.begin() + 1, values.end()}, 1.0);
  chart.id = "correlation-" + sensor.name;
  chart.title = "Autocorrelation of the innovations of " + sensor.name;
  chart.caption +=
      fmt::format("; neighbours above {:.2f} make the deviations of parameters more than {} times too small.",
                  relevant_correlation, suspicious_widening);
  chart.series.push_back(
      {.label = "relevant", .y = std::vector<double>(chart.x.size(), relevant_correlation), .role = Role::predicted});
  return chart;
}

/// How much of the innovations repeats what an excitation did before: a part of the structure that the model lacks.
void add_input_charts(const Study& study, const EstimationOutcome& outcome, const SensorCourse& sensor,
                      Section& section) {
  const auto& [parts, elements, signals] = *study.structure;
  const Index samples = sensor.settled.size();
  const double step = 1.0 / outcome.measurements.sample_rate;
  for (std::size_t i = 0; i < signals.size() && i < parts.inputs.size(); ++i) {
    const double last = sensor.settled_at + static_cast<double>(samples - 1) * step;
    if (!signals[i] || !signals[i]->covers(sensor.settled_at, last)) continue;
    const VectorXd excitation = signals[i]->sample(sensor.settled_at, step, samples).col(0).matrix();
    auto values = cross_correlogram(sensor.settled, excitation, lags);
    if (values.empty()) continue;
    Chart chart = lag_chart(sensor, std::move(values), 0.0);
    chart.id = fmt::format("correlation-{}-{}", sensor.name, parts.inputs[i].name);
    chart.title = fmt::format("Innovations of {} after '{}'", sensor.name, parts.inputs[i].name);
    chart.y_window.reset();
    chart.caption += "; what lies outside is response to the excitation that the model lacks.";
    section.items.emplace_back(std::move(chart));
  }
}

std::vector<double> decibels_of_power(const VectorXd& density) {
  std::vector<double> values;
  for (const double value : density) values.push_back(value > 0.0 ? 10.0 * std::log10(value) : std::nan(""));
  return values;
}

/// Spectra of what was measured, expected and left over, and the coherence of the first two.
void add_spectra(const EstimationOutcome& outcome, const SensorCourse& sensor, Section& section) {
  constexpr Index longest = 2048, fewest_segments = 16, shortest = 32;
  const Index segment = std::min<Index>(longest, 2 * sensor.settled.size() / (fewest_segments + 1));
  if (segment < shortest) return;
  const auto after_settling = [&](const VectorXd& values) -> VectorXd { return values.tail(sensor.settled.size()); };
  const auto pair = spectrum_pair(after_settling(sensor.measured), after_settling(sensor.expected),
                                  outcome.measurements.sample_rate, segment);
  if (pair.segments < 2) return;
  const Chart over_frequency{.x_label = "frequency [Hz]",
                             .x = {pair.lines.begin(), pair.lines.end()},
                             .half_width = true,
                             .fold = fold_of(sensor)};
  Chart spectra = over_frequency;
  spectra.id = "spectrum-" + sensor.name;
  spectra.title = "Spectrum of " + sensor.name;
  spectra.caption =
      fmt::format("Welch's average of {} segments. White innovations have a level spectrum.", pair.segments);
  spectra.y_label = fmt::format("density [dB re ({})²/Hz]", sensor.unit);
  spectra.series = {{.label = "measured", .y = decibels_of_power(pair.first), .role = Role::measured},
                    {.label = "expected", .y = decibels_of_power(pair.second), .role = Role::estimate},
                    {.label = "innovation", .y = decibels_of_power(pair.difference), .role = Role::predicted}};
  Chart coherence = over_frequency;
  coherence.id = "coherence-" + sensor.name;
  coherence.title = "Coherence of " + sensor.name + " with what was expected";
  coherence.caption = "1: the model explains all that was measured at this frequency.";
  coherence.y_label = "coherence [-]";
  coherence.y_window = AxisRange{0.0, 1.05};
  coherence.series = {{.label = "measured with expected", .y = series_values(pair.coherence), .role = Role::estimate}};
  section.items.emplace_back(std::move(spectra));
  section.items.emplace_back(std::move(coherence));
}

/// Outline of a histogram of the standardised innovations beside the normal density.
Chart histogram_chart(const SensorCourse& sensor, const std::vector<double>& sorted) {
  constexpr double reach = 5.0;
  const int bins = std::clamp(static_cast<int>(std::sqrt(static_cast<double>(sorted.size()))), 10, 60);
  const double width = 2.0 * reach / bins;
  Series outline{.label = "innovations", .y = {0.0}, .role = Role::measured, .x = {-reach}};
  for (int b = 0; b < bins; ++b) {
    const double low = -reach + b * width, high = low + width;
    const auto inside = std::ranges::lower_bound(sorted, high) - std::ranges::lower_bound(sorted, low);
    const double density = static_cast<double>(inside) / (static_cast<double>(sorted.size()) * width);
    outline.x.insert(outline.x.end(), {low, high});
    outline.y.insert(outline.y.end(), {density, density});
  }
  outline.x.push_back(reach);
  outline.y.push_back(0.0);
  Series normal{.label = "expected", .role = Role::limit};
  for (int k = 0; k <= 100; ++k) {
    const double x = -reach + 0.02 * reach * k;
    normal.x.push_back(x);
    normal.y.push_back(std::exp(-0.5 * x * x) / std::sqrt(2.0 * std::numbers::pi));
  }
  return {.id = "histogram-" + sensor.name,
          .title = "Distribution of the innovations of " + sensor.name,
          .x_label = "innovation / its expected deviation [-]",
          .y_label = "density [-]",
          .series = {outline, normal},
          .scatter = true,
          .fold = fold_of(sensor)};
}

/// Quantiles of the innovations over those of a normal distribution.
Chart quantile_chart(const SensorCourse& sensor, const std::vector<double>& sorted) {
  constexpr int points = 199;
  Series quantiles{.label = "innovations", .role = Role::measured};
  for (int k = 1; k <= points; ++k) {
    const double probability = k / (points + 1.0);
    quantiles.x.push_back(normal_quantile(probability));
    quantiles.y.push_back(sorted[static_cast<std::size_t>(probability * static_cast<double>(sorted.size()))]);
  }
  const double reach = -quantiles.x.front();
  return {.id = "quantiles-" + sensor.name,
          .title = "Quantiles of the innovations of " + sensor.name,
          .caption = "On the line: normal and as large as expected. Steeper: larger. Bent ends: outliers.",
          .x_label = "normal quantile [-]",
          .y_label = "quantile of innovation / deviation [-]",
          .series = {quantiles, {.label = "expected", .y = {-reach, reach}, .role = Role::limit, .x = {-reach, reach}}},
          .scatter = true,
          .fold = fold_of(sensor)};
}

void add_distribution(const SensorCourse& sensor, Section& section) {
  constexpr Index least = 200;
  if (sensor.known < least) return;
  std::vector<double> sorted;
  for (const double value : sensor.settled)
    if (std::isfinite(value)) sorted.push_back(value);
  std::ranges::sort(sorted);
  section.items.emplace_back(histogram_chart(sensor, sorted));
  section.items.emplace_back(quantile_chart(sensor, sorted));
}

std::vector<std::string> table_row(const SensorCourse& sensor, const std::vector<double>& correlation,
                                   double innovation_to_noise) {
  const auto shares = fmt::format("{:.0f} / {:.0f} / {:.0f} %", 100.0 * sensor.share(Agreement::green),
                                  100.0 * (sensor.share(Agreement::amber) + sensor.share(Agreement::red)),
                                  100.0 * sensor.share(Agreement::small));
  return {sensor.name,
          std::to_string(sensor.known),
          four_digits(sensor.size()),
          per_cent(sensor.inside_95()),
          correlation.size() > 1 ? fmt::format("{:.2f}", correlation[1]) : "-",
          std::isfinite(innovation_to_noise) ? four_digits(innovation_to_noise) : "-",
          shares,
          fmt::format("{:.4g} s", sensor.worst_time())};
}

}  // namespace

Section sensors_section(const Study& study, const EstimationOutcome& outcome) {
  Section section{"Sensors",
                  "What each sensor measured and what the filter expected of it, one sample ahead. The difference, the "
                  "innovation, is white and as large as expected where model, noise and parameters are right.",
                  {}};
  Table table{
      .title = "After settling",
      .columns = {"sensor", "samples", "innovation / expected", "in the 95 % band", "correlation of neighbours",
                  "innovation / noise", "as expected / too large / too small", "worst at"},
      .graphics_title = "agreement over time",
      .caption =
          "Each window of time by the mean square of its innovations. As expected (green): within the 95 % band "
          "of chance. Too large (amber, beyond the 99.9 % band red): the model misses something there. Too small "
          "(blue): the noise is stated too large. The mark leads to the worst moment."};
  Section charts;
  for (Index row = 0; row < outcome.result.innovation.rows(); ++row) {
    const SensorCourse sensor(outcome, row);
    if (!sensor.has_innovations()) continue;
    const auto correlation = correlogram(sensor.settled, lags);
    const double to_noise = outcome.consistency.innovation_to_noise[row];
    table.rows.push_back(table_row(sensor, correlation, to_noise));
    table.graphics.push_back(agreement_strip_svg(sensor, "sensor-" + sensor.name));
    charts.items.emplace_back(course_chart(outcome, sensor, study.report.zoom));
    charts.items.emplace_back(innovation_chart(outcome, sensor, to_noise));
    add_spectra(outcome, sensor, charts);
    if (!correlation.empty()) charts.items.emplace_back(autocorrelation_chart(sensor, correlation));
    add_input_charts(study, outcome, sensor, charts);
    add_distribution(sensor, charts);
  }
  section.items.emplace_back(std::move(table));
  std::ranges::move(charts.items, std::back_inserter(section.items));
  return section;
}

}  // namespace kalfem
