// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/result_set.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kalfem/report/adaptive_noise_report.hpp"
#include "kalfem/report/answer.hpp"
#include "kalfem/report/frequency_report.hpp"
#include "kalfem/report/frequency_response_report.hpp"
#include "kalfem/report/identified_parameters.hpp"
#include "kalfem/report/inference_report.hpp"
#include "kalfem/report/inference_tables.hpp"
#include "kalfem/report/modes_table.hpp"
#include "kalfem/report/placement_report.hpp"
#include "kalfem/report/process_noise_report.hpp"
#include "kalfem/report/sections.hpp"
#include "kalfem/report/statics_report.hpp"
#include "kalfem/report/structure_picture.hpp"
#include "kalfem/report/structure_scene.hpp"
#include "kalfem/report/summary_parts.hpp"
#include "kalfem/report/tables.hpp"
#include "kalfem/report/updating_tables.hpp"
#include "kalfem/statistics/quantiles.hpp"
#include "kalfem/study/structural_modifications.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

Section inputs_section(const EstimationOutcome& outcome) {
  Section section{"Unknown excitations",
                  "Estimated from the sensors alone, with their 95 % bands. " + hardly_known_words(outcome),
                  {input_table(outcome)}};
  for (const auto& input : outcome.inputs) {
    Chart chart{.id = "input-" + input.input.name,
                .title = input.input.name,
                .caption = input.nrmse ? "NRMSE " + per_cent(*input.nrmse) + "." : "",
                .x_label = "time [s]",
                .y_label = input.input.name + " [" + input.input.unit + "]",
                .x = times(outcome.measurements),
                .series = {with_band("estimate", input.mean, input.deviation, Role::estimate)}};
    if (input.truth.size() > 0)
      chart.series.push_back({.label = "true", .y = series_values(input.truth), .role = Role::truth});
    section.items.emplace_back(std::move(chart));
  }
  return section;
}

/// Mean of NIS over windows of about a hundredth of the record, with the 95 % band of such a mean.
Chart nis_chart(const EstimationOutcome& outcome) {
  const Index samples = outcome.result.nis.size(), window = std::max<Index>(1, samples / 100);
  Chart chart{.id = "nis", .title = "Normalised innovation squared", .x_label = "time [s]", .y_label = "mean NIS [-]"};
  Series mean{.label = fmt::format("mean of {} samples", window), .y = {}, .role = Role::estimate};
  Series expected{.label = "expected, with 95 % band", .y = {}, .role = Role::limit};
  for (Index begin = 0; begin + window <= samples; begin += window) {
    double sum = 0.0, degrees = 0.0, count = 0.0;
    for (Index k = begin; k < begin + window; ++k)
      if (std::isfinite(outcome.result.nis[k]))
        sum += outcome.result.nis[k], degrees += outcome.result.measured[k], count += 1.0;
    if (count == 0.0) continue;
    chart.x.push_back(outcome.measurements.time(begin + window / 2));
    mean.y.push_back(sum / count);
    expected.y.push_back(degrees / count);
    expected.lower.push_back(chi_squared_quantile(0.025, degrees) / count);
    expected.upper.push_back(chi_squared_quantile(0.975, degrees) / count);
  }
  chart.series = {mean, expected};
  return chart;
}

Section consistency_section(const EstimationOutcome& outcome) {
  Section section{"Consistency", "", {}};
  if (std::isfinite(outcome.consistency.mean_nis)) {
    section.text = fmt::format("Mean NIS {:.3f} (expected {:.3f}); {:.1f} % of the samples are in the 95 % band.",
                               outcome.consistency.mean_nis, outcome.consistency.expected_nis,
                               100.0 * outcome.consistency.fraction_in_95);
    section.items.emplace_back(nis_chart(outcome));
  }
  section.text += "\n\nThe filter takes " + substep_words(outcome) + "." +
                  (outcome.start.moving ? "\n\nAt the start, " + explain(outcome.start) + "." : "");
  return section;
}

Section open_loop_section(const EstimationOutcome& outcome) {
  Section section{"Open-loop simulation of the record",
                  "Simulated from the estimated parameters and initial state, without correction by measurements.",
                  {open_loop_table(outcome)}};
  for (std::size_t i = 0; i < outcome.measurements.channels.size(); ++i) {
    const auto row = static_cast<Index>(i);
    const auto& channel = outcome.measurements.channels[i];
    section.items.emplace_back(Chart{.id = "open-loop-" + channel.name,
                                     .title = channel.name,
                                     .x_label = "time [s]",
                                     .y_label = "[" + channel.unit + "]",
                                     .x = times(outcome.measurements),
                                     .series = {{.label = "measured",
                                                 .y = series_values(outcome.measurements.values.row(row).transpose()),
                                                 .role = Role::measured},
                                                {.label = "simulated",
                                                 .y = series_values(outcome.open_loop_sensors.row(row).transpose()),
                                                 .role = Role::predicted}}});
  }
  return section;
}

/// The part with each sensor as a whole, and zoomed behind the lead-in.
Section validation_section(const Study& study, const ValidationOutcome& outcome) {
  const auto& [measured, simulated, first, nrmse, noise, one_step, failure] = outcome.held_back;
  Section section{"Validation", validation_words(study, outcome) + ".", {}};
  if (!failure.empty()) return section;
  section.items.emplace_back(validation_table(outcome));
  for (std::size_t j = 0; j < measured.channels.size(); ++j) {
    const auto row = static_cast<Index>(j);
    const auto& channel = measured.channels[j];
    Chart chart{
        .id = "validation-" + channel.name,
        .title = channel.name,
        .caption = fmt::format("NRMSE {}.", four_digits(nrmse[j])),
        .x_label = "time [s]",
        .y_label = "[" + channel.unit + "]",
        .x = times(measured),
        .series = {
            {.label = "measured", .y = series_values(measured.values.row(row).transpose()), .role = Role::measured},
            {.label = "simulated", .y = series_values(simulated.row(row).transpose()), .role = Role::predicted}}};
    section.items.emplace_back(chart);
    chart.id += "-zoom";
    chart.title += ", zoomed";
    chart.x_window =
        AxisRange{measured.time(first), std::min(measured.time(first) + study.report.zoom, measured.end())};
    section.items.emplace_back(std::move(chart));
  }
  return section;
}

/// What fits on the first screen: the parameters, and the structure with the names of everything.
Section overview_section(const Study& study, const StudyResults& results) {
  Section section{"Overview", "", {}};
  if (const auto found = identified_parameters(study, results); !found.empty())
    section.items.emplace_back(identified_parameter_table(found));
  if (auto picture = structure_picture(study)) section.items.emplace_back(std::move(*picture));
  return section;
}

/// The mistakes that were tested, best explanation first; the page shows as many as somebody reads.
Table tested_table(const Diagnosis& diagnosis) {
  constexpr std::size_t shown = 12;
  Table table{"Mistakes that were undone to see whether they explain it",
              {"if", "log-likelihood rises by", "mean NIS then"},
              {},
              {}};
  for (const auto& each : diagnosis.tested)
    if (!each.failed && table.rows.size() < shown)
      table.rows.push_back({each.words, fmt::format("{:.0f}", each.gain), fmt::format("{:.2f}", each.mean_nis)});
  return table;
}

/// Every reason that the verdict has, worst first, with what to do, and which causes were tested.
Section verdict_section(const StudyResults& results) {
  Table table{"Reasons, worst first", {"of", "found", "to do"}, {}, {}};
  for (const auto& reason : results.verdict.reasons())
    table.rows.push_back({reason.subject, reason.text, reason.remedy});
  Section section{"Reasons for doubt", "", {table}};
  if (results.estimation && results.estimation->diagnosis) {
    const auto& diagnosis = *results.estimation->diagnosis;
    section.text = fmt::format(
        "{} mistakes were tested one at a time on the first {:.4g} s of the record: the filter ran again with each of "
        "them "
        "undone. The one under which the record is most likely is the cause, if it explains the record far better.",
        diagnosis.tested.size(), diagnosis.duration);
    section.items.emplace_back(tested_table(diagnosis));
  }
  return section;
}

/// What was wrong with the record or missing in it.
Section events_section(const std::vector<SensorEvent>& events) {
  Table table{"", {"sensor or unknown", "event", "from", "to", "samples", "found"}, {}, {}};
  for (const auto& event : events)
    table.rows.push_back({event.channel.empty() ? "all" : event.channel, to_string(event.kind),
                          fmt::format("{:.6g} s", event.from), fmt::format("{:.6g} s", event.to),
                          std::to_string(event.count), event.text});
  return {"Events in the record", "", {table}};
}

Section simulation_section(const SimulationOutcome& outcome) {
  Section section{"Record", "Simulated sensors, with noise.", {}};
  for (std::size_t i = 0; i < outcome.measurements.channels.size(); ++i) {
    const auto row = static_cast<Index>(i);
    const auto& channel = outcome.measurements.channels[i];
    section.items.emplace_back(Chart{.id = "record-" + channel.name,
                                     .title = channel.name,
                                     .x_label = "time [s]",
                                     .y_label = "[" + channel.unit + "]",
                                     .x = times(outcome.measurements),
                                     .series = {{.label = "recorded",
                                                 .y = series_values(outcome.measurements.values.row(row).transpose()),
                                                 .role = Role::measured},
                                                {.label = "without noise",
                                                 .y = series_values(outcome.reference.sensors.row(row).transpose()),
                                                 .role = Role::truth}},
                                     .half_width = true});
  }
  return section;
}

/// Modes of the finite-element substructures, how their reductions keep them, and what was warned of.
Section model_section(const Study& study, const StudyResults& results) {
  Section section{"Finite-element substructures", "", {modes_table(study, results)}};
  if (results.joined_frequencies.size() > 0) section.items.emplace_back(joined_modes_table(study, results));
  for (const auto& elements : study.structure->finite_elements) {
    section.text += fmt::format("'{}' has {} degrees of freedom and weighs {}. ", elements.part->name,
                                elements.part->full.size(), mass_text(*elements.part));
    if (elements.reduced)
      section.text += fmt::format("The filter's model has {} coordinates of it: {} of the boundary, {}. ",
                                  elements.reduced->model.size(), elements.reduced->boundary.size(),
                                  elements.reduced->error_indicators.reason);
    if (auto scene = structure_scene(study, results, *elements.part)) section.items.emplace_back(std::move(*scene));
  }
  return section;
}

Eigen::Index dofs_of_all(const StudyResults& results) {
  Eigen::Index dofs = 0;
  for (const auto& part : results.modes) dofs += part.dofs;
  return dofs;
}

}  // namespace

Page make_page(const Study& study, const StudyResults& results) {
  Page page{.title = study.title.empty() ? "kalfem" : study.title,
            .subtitle = fmt::format("{} degrees of freedom, {}", dofs_of_all(results),
                                    counted(study.model->system().connector_count(), "connector")),
            .status = results.verdict.state(),
            .summary = answer(study, results),
            .warnings = study.warnings};
  for (const auto& warning : results.warnings)
    if (std::ranges::none_of(results.verdict.reasons(), [&](const auto& each) { return sentence_of(each) == warning; }))
      page.warnings.push_back(warning);
  page.sections.push_back(overview_section(study, results));
  if (results.verdict.state() != VerdictState::consistent) page.sections.push_back(verdict_section(results));
  const bool estimated = results.estimation && results.estimation->has_samples();
  const bool measured_first = estimated && study.record;  // what was measured is what people know
  if (measured_first) page.sections.push_back(sensors_section(study, *results.estimation));
  if (estimated && results.estimation->augmented_model->layout().unknowns > 0)
    page.sections.push_back(parameters_section(study, *results.estimation));
  if (results.updating) page.sections.push_back(updating_section(study, results));
  if (results.estimation && !results.estimation->events.empty())
    page.sections.push_back(events_section(results.estimation->events));
  if (!results.modifications.empty())
    page.sections.push_back({"Modifications",
                             std::string("Natural frequencies predicted without further updating. ") +
                                 (results.updating ? deviations_leave_out : ""),
                             {modification_table(results.modifications)}});
  if (results.placement) page.sections.push_back(placement_section(study, *results.placement));
  if (results.statics) page.sections.push_back(statics_section(*study.statics, *results.statics));
  if (results.frequency_response) page.sections.push_back(frequency_response_section(*results.frequency_response));
  if (results.inference) page.sections.push_back(inference_section(*results.inference));
  if (estimated && !measured_first) page.sections.push_back(sensors_section(study, *results.estimation));
  if (results.validation) page.sections.push_back(validation_section(study, *results.validation));
  if (estimated) {
    const auto& outcome = *results.estimation;
    if (outcome.frequencies) page.sections.push_back(frequencies_section(*outcome.frequencies));
    if (outcome.result.noise) page.sections.push_back(adaptive_noise_section(outcome));
    if (!outcome.process_noise.empty()) page.sections.push_back(process_noise_section(outcome));
    if (!outcome.inputs.empty()) page.sections.push_back(inputs_section(outcome));
    if (outcome.open_loop) page.sections.push_back(open_loop_section(outcome));
    if (!outcome.open_loop_failure.empty())
      page.sections.push_back(
          {"Open-loop simulation of the record", "No comparison: " + outcome.open_loop_failure + ".", {}});
    page.sections.push_back(motion_section(study, outcome));
    if (auto section = connectors_section(study, outcome); !section.items.empty())
      page.sections.push_back(std::move(section));
    if (results.prediction) page.sections.push_back(prediction_section(study, outcome, *results.prediction));
    page.sections.push_back(consistency_section(outcome));
  } else if (results.simulation && results.simulation->measurements.samples() > 0) {
    page.sections.push_back(simulation_section(*results.simulation));
  }
  if (!study.structure->finite_elements.empty()) page.sections.push_back(model_section(study, results));
  for (std::size_t i = 0; i < study.structure->finite_elements.size(); ++i) {
    const FiniteElementPart& part = *study.structure->finite_elements[i].part;
    page.sections.push_back(model_check_section(
        part.name, part.elements,
        model_check_of(part,
                       {.mechanisms = false, .definiteness = false, .frequencies = 0, .needs_mass = !study.statics}),
        study.element_notes[i].notes));
  }
  page.sections.push_back(provenance_section(study, results));
  return page;
}

}  // namespace kalfem
