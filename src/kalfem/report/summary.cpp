// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/result_set.hpp"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include <fmt/format.h>

#include "kalfem/base/hash.hpp"
#include "kalfem/base/version.hpp"
#include "kalfem/report/adaptive_noise_report.hpp"
#include "kalfem/report/data_files.hpp"
#include "kalfem/report/estimation_summary.hpp"
#include "kalfem/report/frequency_report.hpp"
#include "kalfem/report/frequency_response_report.hpp"
#include "kalfem/report/inference_report.hpp"
#include "kalfem/report/placement_report.hpp"
#include "kalfem/report/process_noise_report.hpp"
#include "kalfem/report/run_details.hpp"
#include "kalfem/report/statics_report.hpp"
#include "kalfem/report/summary_parts.hpp"
#include "kalfem/report/tables.hpp"
#include "kalfem/study/structural_modifications.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {
using Json = nlohmann::ordered_json;

void drop_times(Json& json) {
  if (json.is_object()) {
    json.erase("seconds");
    json.erase("timing");
  }
  for (auto& item : json)
    if (item.is_structured()) drop_times(item);
}

namespace {

/// What all files of one run carry, so that files of two runs are told apart: 16 hexadecimal digits, a hash of the case
/// with all its defaults and of the numbers in its summary. Times that were taken are left out: the same run again has
/// the same identity.
std::string run_identity(const Study& study, const Json& summary) {
  Json numbers = summary;
  drop_times(numbers);
  Hash hash;
  hash.add(study.resolved_case);
  hash.add(numbers.dump(-1, ' ', false, Json::error_handler_t::replace));
  return fmt::format("{:016x}", hash.value());
}

Json reduction_summary(const Superelement& superelement) {
  const auto& error_indicators = superelement.error_indicators;
  Json modes = Json::array();
  for (const auto& mode : error_indicators.modes)
    modes.push_back({{"full_hz", number(mode.full)},
                     {"reduced_hz", number(mode.reduced)},
                     {"mac", number(mode.mac)},
                     {"residual", number(mode.residual)}});
  return {{"dofs", superelement.model.size()},
          {"boundary", superelement.boundary.size()},
          {"reason", error_indicators.reason},
          {"highest_kept_hz", number(error_indicators.highest_kept)},
          {"next_left_out_hz", number(error_indicators.next_left_out)},
          {"static_error", number(error_indicators.static_error)},
          {"modes", modes}};
}

Json vector_json(const Eigen::Vector3d& vector) {
  return Json::array({number(vector[0]), number(vector[1]), number(vector[2])});
}

Json model_summary(const Study& study, const StudyResults& results) {
  Json parts = Json::object();
  Eigen::Index dofs = 0;
  for (const auto& part : results.modes) {
    Json frequencies = Json::array();
    for (const double f : part.frequencies) frequencies.push_back(number(f));
    parts[part.name] = {{"dofs", part.dofs}, {"mass", number(part.mass)}, {"frequencies_hz", frequencies}};
    dofs += part.dofs;
  }
  for (const auto& elements : study.structure->finite_elements) {
    const auto& part = *elements.part;
    parts[part.name]["moving_mass"] = vector_json(part.moving_mass);
    if (!part.elements.mesh.nodes.isZero(0.0))  // of matrices without coordinates
      parts[part.name]["centre_of_gravity"] = vector_json(part.mass.centre);
  }
  for (const auto& elements : study.structure->finite_elements)
    if (elements.reduced) parts[elements.part->name]["reduction"] = reduction_summary(*elements.reduced);
  Json model = {{"dofs", dofs},
                {"reduced_dofs",
                 study.augmented_model ? study.augmented_model->model->system().size() : study.model->system().size()},
                {"connectors", study.model->system().connector_count()},
                {"substructures", parts}};
  if (results.joined_frequencies.size() > 0) model["joined_frequencies_hz"] = numbers(results.joined_frequencies);
  return model;
}

Json prediction_summary(const StudyResults& results) {
  Json summary = Json::object();
  if (results.prediction) {
    Json& points = summary[results.prediction->substructure];
    const RestingPoints resting(results.prediction->points, results.estimation->settled);
    for (const auto& point : results.prediction->points)
      add_errors(points[point.point.substr(point.point.find('.') + 1)], point, resting);
  }
  for (const auto& each : results.modifications) {
    Json frequencies = Json::array();
    for (const double f : each.frequencies) frequencies.push_back(number(f));
    Json& modification = summary[each.name];
    modification = {{"substructure", each.substructure}, {"frequencies_hz", frequencies}};
    if (each.deviations.size() == 0) continue;
    modification["frequencies_std_hz"] = Json::array();
    for (const double deviation : each.deviations) modification["frequencies_std_hz"].push_back(number(deviation));
    modification["note"] = deviations_leave_out;
  }
  return summary;
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

Json timing_summary(const Study& study, const StudyResults& results) {
  Json timing = {{"total_s", number(results.total_seconds)}};
  const PhaseTimes times = step_times(study, results);
  for (const auto& [step, seconds] : times.list()) timing[step + "_s"] = number(seconds);
  for (const auto& [part, seconds] : study.reduce_phases.list()) timing["reduce_split_s"][part] = number(seconds);
  if (results.estimation) {
    const auto& outcome = *results.estimation;
    const auto steps = static_cast<double>(outcome.measurements.samples());
    timing["estimate_us_per_step"] = number(1e6 * outcome.result.time.filter() / steps);
    timing["real_time_factor"] = number(steps / outcome.measurements.sample_rate / outcome.result.time.filter());
    timing["estimate_split_s"] = {{"predict", number(outcome.result.time.predict)},
                                  {"update", number(outcome.result.time.update)},
                                  {"output", number(outcome.result.time.output)}};
    timing["first_answer"] = {{"after_s", number(outcome.first_answer_seconds)}};
  }
  return timing;
}

/// Nothing where the step was not refined.
Json last_change(const Study& study, const ConvergedSolution& reference) {
  return study.simulation->has_fixed_step() ? Json() : number(reference.last_change);
}

Json verdict_summary(const Verdict& verdict) {
  Json reasons = Json::array();
  for (const auto& reason : verdict.reasons())
    reasons.push_back(
        {{"code", reason.code}, {"subject", reason.subject}, {"text", reason.text}, {"remedy", reason.remedy}});
  return {{"state", to_string(verdict.state())}, {"reasons", reasons}};
}

/// Null where nothing was estimated.
Json second_thoughts_summary(const StudyResults& results) {
  return results.estimation ? Json(to_string(results.estimation->second_thoughts)) : Json();
}

}  // namespace

Json summarise(const Study& study, const StudyResults& results) {
  Json summary = {{"kalfem", version},
                  {"run", ""},
                  {"case", std::filesystem::path(study.file).filename().string()},
                  {"title", study.title},
                  {"status", results.usable() ? "ok" : "unusable"},
                  {"message", results.why_unusable()},
                  {"second_thoughts", second_thoughts_summary(results)},
                  {"verdict", verdict_summary(results.verdict)},
                  {"model", model_summary(study, results)}};
  std::vector<std::string> warnings = study.warnings;
  warnings.insert(warnings.end(), results.warnings.begin(), results.warnings.end());
  if (!warnings.empty()) summary["warnings"] = warnings;
  if (results.simulation)
    summary["simulation"] = {{"steps_per_sample", results.simulation->reference.substeps},
                             {"extrapolations", results.simulation->reference.extrapolations},
                             {"fixed_step", study.simulation->has_fixed_step()},
                             {"last_change", last_change(study, results.simulation->reference)},
                             {"solve_error", results.simulation->reference.simulation.solve_error}};
  if (study.record) summary["record"] = record_summary(study, results);
  if (results.estimation) {
    summary["parameters"] = parameters_summary(study, *results.estimation);
    if (!results.estimation->inputs.empty()) {
      summary["inputs"] = inputs_summary(results.estimation->inputs, results.estimation->settled);
      summary["hardly_known"] = results.estimation->hardly_known;
    }
    summary["estimation"] = estimation_summary(*results.estimation);
    if (!results.estimation->left_out.empty()) summary["estimation"]["left_out"] = results.estimation->left_out;
    if (!results.estimation->events.empty()) summary["events"] = events_summary(*results.estimation);
    if (results.estimation->result.noise)
      summary["estimation"]["adaptive_noise"] = adaptive_noise_summary(*results.estimation);
    if (!results.estimation->process_noise.empty())
      summary["estimation"]["process_noise"] = process_noise_summary(*results.estimation);
    if (const auto& course = results.estimation->frequencies) summary["frequencies"] = frequencies_summary(*course);
    if (results.estimation->smoothed) summary["smoothed"] = smoothed_summary(*results.estimation);
    if (const auto& diagnosis = results.estimation->diagnosis) summary["diagnosis"] = diagnosis_summary(*diagnosis);
  }
  if (results.validation) {
    summary["validation"] = validation_summary(*results.validation);
    summary["validation_record"] = validation_record_summary(*study.validation, results.validation->held_back);
  }
  if (results.prediction || !results.modifications.empty()) summary["prediction"] = prediction_summary(results);
  if (results.updating) summary["updating"] = updating_summary(study, *results.updating);
  if (results.inference) summary["inference"] = inference_summary(*results.inference);
  if (results.placement) summary["placement"] = placement_summary(*results.placement);
  if (results.statics) summary["statics"] = statics_summary(*study.statics, *results.statics);
  if (results.frequency_response)
    summary["frequency_response"] = frequency_response_summary(*results.frequency_response);
  if (results.identified)
    summary["identified"] = {{"file", "case.identified.yaml"}, {"notes", results.identified->notes}};
  for (const auto& [path, bytes, sha256] : data_files(study))
    summary["data"].push_back({{"file", path.string()}, {"bytes", bytes}, {"sha256", sha256}});
  summary["run"] = run_identity(study, summary);
  summary["timing"] = timing_summary(study, results);
  return summary;
}

}  // namespace kalfem
