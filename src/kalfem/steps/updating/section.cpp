// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>

#include "kalfem/page/chart_series.hpp"
#include "kalfem/page/frf_charts.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/pictures/heat_map.hpp"
#include "kalfem/steps/updating/report.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXcd;

/// The parameters of every iteration, relative to their initial values.
Chart trace_chart(const Study& study, const UpdatingOutcome& outcome) {
  Chart chart{.id = "updating-trace",
              .title = "Parameters by iteration",
              .caption = "Accepted values, relative to the initial values.",
              .x_label = "iteration",
              .y_label = "value / initial [-]"};
  for (std::size_t k = 0; k < outcome.trace.size(); ++k) chart.x.push_back(static_cast<double>(k + 1));
  for (std::size_t i = 0; i < study.updating->parameters.size(); ++i) {
    const auto& parameter = study.updating->parameters[i];
    Series series{.label = parameter.name, .role = Role::other};
    for (const auto& step : outcome.trace)
      series.y.push_back(step.parameters[static_cast<Index>(i)] / parameter.scale());
    chart.series.push_back(std::move(series));
  }
  return chart;
}

Chart residual_chart(const UpdatingOutcome& outcome) {
  Chart chart{
      .id = "updating-residual", .title = "Residual by iteration", .x_label = "iteration", .y_label = "rms [std]"};
  Series series{.label = "accepted", .role = Role::estimate};
  for (std::size_t k = 0; k < outcome.trace.size(); ++k) {
    chart.x.push_back(static_cast<double>(k + 1));
    series.y.push_back(outcome.trace[k].residual);
  }
  chart.series.push_back(std::move(series));
  return chart;
}

/// Frequency response assurance criterion, |H_m^H H_a|^2 / (H_m^H H_m  H_a^H H_a) in [0, 1] [All03].
double frac(const VectorXcd& measured, const VectorXcd& model) {
  const double sizes = measured.squaredNorm() * model.squaredNorm();
  return sizes > 0.0 ? std::norm(measured.dot(model)) / sizes : std::nan("");
}

/// Magnitude, phase and coherence of one response; the latter two where they were measured.
void add_response_charts(const std::string& comparison, const FrfCurve& curve, std::size_t number, Section& section) {
  const FrfChartWords words{.id = fmt::format("{}-{}", comparison, number),
                            .title = curve.quantity + " at " + curve.name,
                            .unit = curve.unit};
  const std::vector<FrfSeries> series{{"measured", curve.measured, Role::measured},
                                      {"before", curve.before, Role::initial},
                                      {"after", curve.after, Role::estimate}};
  Chart magnitude = magnitude_chart(words, curve.lines, series);
  if (!curve.magnitudes_only)
    magnitude.caption = fmt::format("FRAC {:.3f} before, {:.3f} after the updating.",
                                    frac(curve.measured, curve.before), frac(curve.measured, curve.after));
  section.items.emplace_back(std::move(magnitude));
  if (!curve.magnitudes_only) section.items.emplace_back(phase_chart(words, curve.lines, series));
  if (curve.coherence.size() == 0) return;
  section.items.emplace_back(
      Chart{.id = "coherence-" + words.id,
            .title = words.title,
            .x_label = "frequency [Hz]",
            .y_label = "coherence [-]",
            .x = series_values(curve.lines),
            .series = {{.label = "measured", .y = series_values(curve.coherence), .role = Role::measured}},
            .y_window = AxisRange{0.0, 1.05},
            .half_width = true});
}

/// The MAC of all measured modes with those of the model.
Picture mac_picture(const ComparisonResult& comparison, bool after) {
  HeatMap map{.name = "MAC of measured and model modes",
              .values = after ? comparison.mac_final : comparison.mac_initial,
              .row_title = "measured",
              .column_title = "model"};
  for (const auto& mode : after ? comparison.modes_final : comparison.modes_initial)
    map.rows.push_back(four_digits(mode.measured_frequency) + " Hz");
  for (Index j = 0; j < map.values.cols(); ++j) map.columns.push_back(std::to_string(j + 1));
  return {.title = std::string("MAC ") + (after ? "after" : "before") + " the updating",
          .caption = "Rows: measured modes. Columns: elastic modes of the model.",
          .svg = heat_map_svg(map),
          .half_width = true};
}

Picture correlation_picture(const Study& study, const UpdatingOutcome& outcome) {
  HeatMap map{
      .name = "Correlation of the updated parameters", .values = outcome.statistics.correlation, .diverging = true};
  for (const auto& parameter : study.updating->parameters) map.rows.push_back(parameter.name);
  map.columns = map.rows;
  return {.title = "Correlation of the parameters",
          .caption = "Near 1 or −1: the data tell the two apart badly.",
          .svg = heat_map_svg(map),
          .half_width = true};
}

std::string words_on(const Study& study, const UpdatingOutcome& outcome) {
  std::string text = fmt::format("{} evaluations, {} steps, {:.1f} s, by {}. {}. ", outcome.evaluations,
                                 outcome.iterations, outcome.seconds, outcome.method, capitalised(outcome.termination));
  for (const auto& remark : outcome.remarks) text += "\n\n" + capitalised(remark) + ".";
  for (const auto& remark : outcome.first.remarks) text += "\n\nBefore the updating: " + remark;
  for (const auto& sentence : proposal_in_words(study.updating->parameters, outcome.first.proposal))
    text += "\n\nProposed: " + sentence + ".";
  return text;
}

}  // namespace

Section updating_section(const Study& study, const StudyResults& results) {
  const auto& outcome = results.get<UpdatingOutcome>();
  Section section{
      "Updated model", words_on(study, outcome), {updated_parameter_table(study, outcome), comparison_table(outcome)}};
  for (const auto& each : outcome.first.frequencies)
    section.items.emplace_back(frequency_sensitivity_table(study, each));
  if (auto table = before_and_after_table(study, results); !table.rows.empty())
    section.items.emplace_back(std::move(table));
  for (const auto& comparison : outcome.comparisons)
    if (!comparison.modes_final.empty()) {
      section.items.emplace_back(paired_mode_table(comparison));
      section.items.emplace_back(mac_picture(comparison, false));
      section.items.emplace_back(mac_picture(comparison, true));
    }
  if (!outcome.alternatives.empty()) section.items.emplace_back(alternatives_table(outcome));
  if (!outcome.minima.empty()) section.items.emplace_back(minima_table(study, outcome));
  if (outcome.statistics.correlation.rows() > 1) {
    section.items.emplace_back(correlation_picture(study, outcome));
  }
  if (!outcome.sensitivities.empty()) section.items.emplace_back(sensitivity_table(outcome));
  if (outcome.trace.size() > 1) {
    section.items.emplace_back(trace_chart(study, outcome));
    section.items.emplace_back(residual_chart(outcome));
    section.items.emplace_back(updating_trace_table(study, outcome));
  }
  for (const auto& comparison : outcome.comparisons)
    for (std::size_t i = 0; i < comparison.responses.size(); ++i)
      add_response_charts(comparison.name, comparison.responses[i], i + 1, section);
  return section;
}

}  // namespace kalfem
