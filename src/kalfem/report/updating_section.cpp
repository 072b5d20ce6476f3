#include "kalfem/report/updating_section.hpp"

#include <fmt/format.h>

#include <cctype>
#include <cmath>

#include "kalfem/report/updating_tables.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

std::vector<double> list(const Eigen::VectorXd& values) { return {values.begin(), values.end()}; }

/// The parameters of every stage, as parts of where they started.
Chart trace_chart(const Study& study, const UpdatingOutcome& outcome) {
  Chart chart{.id = "updating-trace",
              .title = "Parameters by stage",
              .caption = "As accepted, in parts of the first values.",
              .x_label = "stage",
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
  Chart chart{.id = "updating-residual", .title = "Residual by stage", .x_label = "stage", .y_label = "rms [std]"};
  Series series{.label = "accepted", .role = Role::estimate};
  for (std::size_t k = 0; k < outcome.trace.size(); ++k) {
    chart.x.push_back(static_cast<double>(k + 1));
    series.y.push_back(outcome.trace[k].residual);
  }
  chart.series.push_back(std::move(series));
  return chart;
}

std::vector<double> decibels(const Eigen::VectorXd& magnitudes) {
  std::vector<double> values;
  for (const double value : magnitudes) values.push_back(20.0 * std::log10(value));
  return values;
}

Chart response_chart(const std::string& comparison, const FrfCurve& curve, std::size_t number) {
  return {.id = fmt::format("frf-{}-{}", comparison, number),
          .title = curve.name,
          .x_label = "frequency [Hz]",
          .y_label = "magnitude [dB re SI]",
          .x = list(curve.lines),
          .series = {{.label = "measured", .y = decibels(curve.measured), .role = Role::measured},
                     {.label = "before", .y = decibels(curve.before), .role = Role::predicted},
                     {.label = "after", .y = decibels(curve.after), .role = Role::estimate}},
          .half_width = true};
}

std::string sentence(std::string words) {
  if (!words.empty()) words.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(words.front())));
  return words;
}

std::string words_on(const UpdatingOutcome& outcome) {
  std::string text = fmt::format("{} evaluations, {} steps, {:.1f} s, by {}. {}. ", outcome.evaluations,
                                 outcome.iterations, outcome.seconds, outcome.method, sentence(outcome.termination));
  for (const auto& remark : outcome.remarks) text += "\n\n" + sentence(remark) + ".";
  return text;
}

}  // namespace

Section updating_section(const Study& study, const StudyResults& results) {
  const auto& outcome = *results.updating;
  Section section{
      "Updated model", words_on(outcome), {updated_parameter_table(study, outcome), comparison_table(outcome)}};
  if (auto table = before_and_after_table(study, results); !table.rows.empty())
    section.items.emplace_back(std::move(table));
  for (const auto& comparison : outcome.comparisons)
    if (!comparison.modes_final.empty()) section.items.emplace_back(paired_mode_table(comparison));
  if (outcome.statistics.correlation.rows() > 1) section.items.emplace_back(correlation_table(study, outcome));
  if (!outcome.sensitivities.empty()) section.items.emplace_back(sensitivity_table(outcome));
  if (outcome.trace.size() > 1) {
    section.items.emplace_back(trace_chart(study, outcome));
    section.items.emplace_back(residual_chart(outcome));
    section.items.emplace_back(updating_trace_table(study, outcome));
  }
  for (const auto& comparison : outcome.comparisons)
    for (std::size_t i = 0; i < comparison.responses.size(); ++i)
      section.items.emplace_back(response_chart(comparison.name, comparison.responses[i], i + 1));
  return section;
}

}  // namespace kalfem
