// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "kalfem/page/chart_series.hpp"
#include "kalfem/page/json_number.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/run_step.hpp"
#include "kalfem/steps/updating/outcome.hpp"
#include "kalfem/steps/validation/outcome.hpp"
#include "kalfem/steps/validation/report.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Json = nlohmann::ordered_json;

/// The parts that hold what the updating and the filter found, without the unknowns that connectors carry.
StructureParts parts_for_validation(const RunContext& context) {
  const Study& study = context.study;
  if (const auto* updating = context.results.find<UpdatingOutcome>())
    return study.updating_plan->structure->at(updating->values).parts;
  const auto& linear = context.augmented_model->linear_unknowns;
  return linear.bindings.empty()
             ? study.structure->parts
             : parts_at(*study.problem, linear, linear_estimates(context.results.get<EstimationOutcome>()));
}

/// The case's own record as a part, with at most half of it as lead-in.
ValidationPart own_part(const PreparedRecord& prepared, const Study& study) {
  const auto& plan = *study.validation;
  const double length = prepared.record.end() - prepared.record.start;
  return {prepared, study.structure->signals, std::min(plan.lead_in, 0.5 * length), plan.from_rest};
}

ValidationProblem problem_of(const RunContext& context) {
  const Study& study = context.study;
  ValidationProblem problem{.structure = {study.structure, parts_for_validation(context), study.sensors, {}, {}},
                            .held_back = static_cast<const ValidationPart&>(*study.validation)};
  if (study.record) problem.own = own_part(*study.record, study);
  const auto* estimation = context.results.find<EstimationOutcome>();
  if (!study.problem || !estimation) return problem;
  problem.structure = at_estimates(*study.problem, std::move(problem.structure.parts), *estimation);
  problem.motion = range_of(*estimation);
  problem.steps = estimation->steps_left;
  problem.held_back.record = without_sensor_errors(std::move(problem.held_back.record), *estimation);
  if (problem.own) problem.own->record = without_sensor_errors(std::move(problem.own->record), *estimation);
  return problem;
}

void run_validation(RunContext& context) {
  auto& results = context.results;
  context.job.begin("validate");
  const auto& outcome = results.put(results.phases.measure("validate", [&] { return validate(problem_of(context)); }));
  auto* estimation = results.find<EstimationOutcome>();
  if (estimation && outcome.one_step_left_out)
    estimation->leave_out("the prediction of the validation one sample ahead");
}

Json validation_summary(const ValidationOutcome& outcome) {
  Json sensors = Json::object();
  const auto &held_back = outcome.held_back, &own = outcome.own;
  for (std::size_t j = 0; j < held_back.nrmse.size(); ++j)
    sensors[held_back.measured.channels[j].name] = {
        {"nrmse", number(held_back.nrmse[j])},
        {"nrmse_estimated_part", j < own.nrmse.size() ? number(own.nrmse[j]) : Json(nullptr)},
        {"one_step_nrmse", j < held_back.one_step.size() ? number(held_back.one_step[j]) : Json(nullptr)},
        {"noise", number(held_back.noise[j])}};
  return sensors;
}

Json validation_record_summary(const ValidationPlan& plan, const OpenLoopComparison& comparison) {
  const auto& record = plan.record.record;
  Json summary = {{"file", std::filesystem::path(plan.file).filename().string()},
                  {"start_s", number(record.start)},
                  {"end_s", number(record.end())},
                  {"samples", record.samples()},
                  {"sample_rate_hz", number(record.sample_rate)},
                  {"initial", plan.from_rest ? "rest" : "unknown"}};
  if (!plan.record.preparation.empty()) summary["preparation"] = plan.record.preparation;
  if (comparison.failure.empty())
    summary["compared_from_s"] = number(record.time(comparison.first));
  else
    summary["failure"] = comparison.failure;
  return summary;
}

std::string told(const Study& study, const StudyResults& results) {
  const auto& outcome = results.get<ValidationOutcome>();
  return validation_words(study, outcome) + "\n" +
         (outcome.held_back.failure.empty() ? to_text(validation_table(outcome)) : "") + "\n";
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

/// Both columns over the time of the validation part, which has its own sampling rate.
void write_validation(SeriesWriter& file, const OpenLoopComparison& comparison) {
  const auto& measured = comparison.measured;
  Eigen::VectorXd time(measured.samples());
  for (Eigen::Index k = 0; k < time.size(); ++k) time[k] = measured.time(k);
  file.write_column("/validation/time", time, "s");
  for (std::size_t j = 0; j < measured.channels.size(); ++j) {
    const auto row = static_cast<Eigen::Index>(j);
    const std::string name = "/validation/" + measured.channels[j].name;
    file.write_column(name + "/measured", measured.values.row(row).transpose(), measured.channels[j].unit);
    if (comparison.simulated.size() > 0)
      file.write_column(name + "/simulated", comparison.simulated.row(row).transpose(), measured.channels[j].unit);
  }
}

}  // namespace

RunStep validation_step() {
  return {.name = "validate",
          .asked_for = [](const Study& study) { return study.validation.has_value(); },
          .after = {"update", "estimate"},
          .phases =
              [](const Study&) {
                return std::vector<PlannedStep>{{"validate", 1.0}};
              },
          .run = &run_validation,
          .ran = &has_outcome<ValidationOutcome>,
          .summarise =
              [](const Study& study, const StudyResults& results, Json& summary) {
                const auto& outcome = results.get<ValidationOutcome>();
                summary["validation"] = validation_summary(outcome);
                summary["validation_record"] = validation_record_summary(*study.validation, outcome.held_back);
              },
          .tell = &told,
          .sections = [](const Study& study, const StudyResults& results) -> std::vector<PlacedSection> {
            return {{PagePlace::validation, validation_section(study, results.get<ValidationOutcome>())}};
          },
          .visit = [](const Study&, const StudyResults& results,
                      SeriesWriter& file) { write_validation(file, results.get<ValidationOutcome>().held_back); }};
}

}  // namespace kalfem
