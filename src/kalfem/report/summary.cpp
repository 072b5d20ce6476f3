#include "kalfem/report/result_set.hpp"

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include <fmt/format.h>

#include "kalfem/base/hash.hpp"
#include "kalfem/base/version.hpp"
#include "kalfem/diagnosis/judge_estimation.hpp"
#include "kalfem/identification/stated_interval.hpp"
#include "kalfem/identification/walked_range.hpp"
#include "kalfem/report/adaptive_noise_report.hpp"
#include "kalfem/report/data_files.hpp"
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

void add_likelihood_unknowns(const LikelihoodEstimate& likelihood, Json& parameters) {
  for (std::size_t i = 0; i < likelihood.unknowns.size(); ++i) {
    const auto& unknown = likelihood.unknowns[i];
    const auto index = static_cast<Eigen::Index>(i);
    const auto interval = likelihood.interval(index);
    parameters[unknown.name] = {{"true", number(unknown.truth)},
                                {"initial", number(unknown.initial)},
                                {"estimate", number(likelihood.values[index])},
                                {"std", number(likelihood.deviation[index])},
                                {"std_robust", number(likelihood.robust_deviation[index])},
                                {"interval_95", {number(interval.lower), number(interval.upper)}},
                                {"interval_95_from", interval.robust ? "std_robust" : "std"},
                                {"prior_std", number(unknown.deviation)},
                                {"found_by", "maximum likelihood"},
                                {"visible", bool(likelihood.visible[i])},
                                {"unit", unknown.unit}};
  }
}

Json parameters_summary(const Study& study, const EstimationOutcome& outcome) {
  Json parameters = Json::object();
  const auto last = outcome.result.unknowns.mean.cols() - 1;
  const auto& layout = outcome.augmented_model->layout();
  const auto against_priors = estimated_unknowns(outcome);
  for (Eigen::Index i = 0; i < layout.unknowns; ++i) {
    const auto index = static_cast<std::size_t>(i);
    const auto& unknown = outcome.augmented_model->options().unknowns[index];
    const auto interval = stated_interval(outcome, i);
    const auto& beside_prior = against_priors[index];
    parameters[unknown.name] = {{"true", number(study.augmented_model->true_parameters[index])},
                                {"initial", number(unknown.initial)},
                                {"estimate", number(outcome.result.unknowns.mean(i, last))},
                                {"std", number(outcome.result.unknowns.deviation(i, last))},
                                {"std_robust", number(outcome.robust_deviation[i])},
                                {"interval_95", {number(interval.lower), number(interval.upper)}},
                                {"interval_95_from", interval.robust ? "std_robust" : "std"},
                                {"prior_std", number(unknown.deviation)},
                                {"moved_prior_std", number(beside_prior.moved)},
                                {"shrinkage", number(beside_prior.shrinkage)},
                                {"unit", unknown.unit}};
    if (const auto range = walked_range(outcome, i)) {
      parameters[unknown.name]["range"] = {number(range->least), number(range->greatest)};
      parameters[unknown.name]["range_95"] = {number(range->lower), number(range->upper)};
    }
  }
  if (outcome.likelihood) add_likelihood_unknowns(*outcome.likelihood, parameters);
  return parameters;
}

/// Excitations that were not measured.
Json inputs_summary(const std::vector<EstimatedInput>& estimated, Eigen::Index settled) {
  Json inputs = Json::object();
  for (const auto& input : estimated) {
    const auto count = static_cast<double>(input.mean.size());
    inputs[input.input.name] = {{"unit", input.input.unit},
                                {"rms", number(input.mean.norm() / std::sqrt(count))},
                                {"std_rms", number(input.deviation.norm() / std::sqrt(count))},
                                {"prior_std", number(input.input.deviation)},
                                {"shrinkage", number(input.shrinkage(settled))},
                                {"nrmse", number(input.nrmse)},
                                {"coverage_95", number(input.coverage)}};
  }
  return inputs;
}

const char* quantity_key(ObservedQuantity quantity) {
  switch (quantity) {
    case ObservedQuantity::displacement:
      return "displacement_nrmse";
    case ObservedQuantity::velocity:
      return "velocity_nrmse";
    case ObservedQuantity::acceleration:
      return "acceleration_nrmse";
    case ObservedQuantity::connector_deformation:
      return "deformation_nrmse";
    case ObservedQuantity::connector_rate:
      return "rate_nrmse";
    case ObservedQuantity::connector_force:
      return "force_nrmse";
    case ObservedQuantity::strain:
      return "strain_nrmse";
  }
  return "";
}

/// Null for points that do not move.
void add_errors(Json& errors, const PointQuantity& point, const RestingPoints& resting) {
  const std::string key = quantity_key(point.quantity);
  const bool rests = resting.rests(point);
  errors[key] = rests ? Json(nullptr) : number(point.nrmse);
  if (point.nrmse_in_band) errors[key + "_in_band"] = rests ? Json(nullptr) : number(*point.nrmse_in_band);
  if (point.coverage) errors["strain_coverage_95"] = number(*point.coverage);
}

Json errors_by_point(const std::vector<PointQuantity>& points, Eigen::Index settled) {
  const RestingPoints resting(points, settled);
  Json errors = Json::object();
  for (const auto& point : points)
    if (point.truth.size() > 0) add_errors(errors[point.point], point, resting);
  return errors;
}

Json open_loop_summary(const EstimationOutcome& outcome) {
  Json sensors = Json::object();
  for (std::size_t i = 0; i < outcome.open_loop_nrmse.size(); ++i)
    sensors[outcome.measurements.channels[i].name] = {{"nrmse", number(outcome.open_loop_nrmse[i])},
                                                      {"rest_error", number(outcome.open_loop_rest_error[i])}};
  return sensors;
}

/// In standard deviations, by unknown.
Json substep_biases(const EstimationOutcome& outcome) {
  Json biases = Json::object();
  for (Eigen::Index i = 0; i < outcome.substeps.bias.size(); ++i)
    biases[outcome.augmented_model->options().unknowns[static_cast<std::size_t>(i)].name] =
        number(outcome.substeps.bias[i]);
  return biases;
}

/// What the robust deviations were found by.
std::string robust_method(const RobustCovariance& robust) {
  std::string method =
      "sandwich of the information and the long-run covariance of the scores (Parzen kernel; Andrews' plug-in "
      "bandwidth, the longest of those of the scores and of their sums over 2, 4, 8 ... neighbours; variances made up "
      "for the scores' sum of zero, Kiefer and Vogelsang 2005, Bell and McCaffrey 2002)";
  if (robust.batch_means) method += "; for some parameters the larger scatter of the means of 25 batches";
  if ((robust.widening_by_bands.array() > 1.0).any())
    method +=
        "; for some parameters the larger contradiction between frequency bands (clusters of one octave, of all "
        "sensors or of each; CR2, Bell and McCaffrey 2002)";
  return method;
}

/// Filters that were tried, in order, and how each ended.
Json attempts_summary(const EstimationOutcome& outcome) {
  Json attempts = Json::array();
  for (const auto& [filter, coordinates, failure] : outcome.attempts) {
    Json attempt = {{"filter", to_string(filter)},
                    {"coordinates", coordinates == StateCoordinates::modal ? "modal" : "physical"},
                    {"usable", !failure}};
    if (failure) {
      attempt["stopped_s"] = number(outcome.measurements.start + failure->time);
      attempt["reason"] = failure->reason;
    }
    attempts.push_back(std::move(attempt));
  }
  return attempts;
}

/// NIS over the whole record and in its loudest part. What was not computed is null.
Json nis_summary(const EstimationOutcome& outcome) {
  const auto& consistency = outcome.consistency;
  Json summary = {{"mean", number(consistency.mean_nis)},
                  {"expected", number(consistency.expected_nis)},
                  {"fraction_in_95", number(consistency.fraction_in_95)}};
  const auto found = nis_consistency(innovations_of(outcome));
  if (found.samples == 0) return summary;
  summary["beyond_half_gate"] = number(found.beyond_half_gate);
  summary["largest_part"] = {{"mean", number(found.largest_part * found.mean_degrees)},
                             {"from_s", number(found.part_begin)},
                             {"to_s", number(found.part_end)}};
  return summary;
}

/// What the verdict looks at, sensor by sensor, each with its sentence.
Json innovations_summary(const EstimationOutcome& outcome, const std::vector<SensorConsistency>& sensors) {
  Json summary = Json::object();
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const auto& found = sensors[i];
    if (found.samples == 0) continue;
    summary[outcome.measurements.channels[i].name] = {
        {"rms_over_expected", number(found.ratio)},
        {"largest_part", number(found.largest_part)},
        {"correlation", number(found.lag_one.value)},
        {"beyond_half_gate", number(found.beyond_half_gate)},
        {"text", fmt::format("{:.3g} times as large as expected over {} samples, {:.3g} times in the loudest part; "
                             "successive ones correlate by {:.2g}; {:.2g} % lie beyond half the gate",
                             found.ratio, found.samples, found.largest_part, found.lag_one.value,
                             100.0 * found.beyond_half_gate)}};
  }
  return summary;
}

Json estimation_summary(const EstimationOutcome& outcome) {
  Json ratios = Json::object();
  for (std::size_t i = 0; i < outcome.measurements.channels.size(); ++i)
    ratios[outcome.measurements.channels[i].name] =
        number(outcome.consistency.innovation_to_noise[static_cast<Eigen::Index>(i)]);
  Json correlations = Json::object();
  const auto sensors = sensor_consistency(innovations_of(outcome));
  for (std::size_t i = 0; i < sensors.size(); ++i)
    correlations[outcome.measurements.channels[i].name] = number(sensors[i].lag_one.value);
  Json summary = {{"filter", to_string(outcome.filter)},
                  {"filter_reason", outcome.filter_reason},
                  {"steps", outcome.measurements.samples()},
                  {"state_dimension", outcome.augmented_model->layout().size()},
                  {"log_likelihood", number(outcome.result.log_likelihood)},
                  {"nis", nis_summary(outcome)},
                  {"innovation_to_noise", ratios},
                  {"innovation_correlation", correlations},
                  {"innovations", innovations_summary(outcome, sensors)}};
  summary["substeps"] = outcome.substeps.substeps;
  summary["substeps_chosen"] = outcome.substeps.chosen;
  if (outcome.substeps.bias.size() > 0) summary["substep_bias"] = substep_biases(outcome);
  summary["start"] = {{"moving", outcome.start.moving}, {"reason", explain(outcome.start)}};
  if (outcome.start.moving) {
    summary["start"]["displacement_std"] = number(outcome.start.displacement);
    summary["start"]["velocity_std"] = number(outcome.start.velocity);
  }
  if (outcome.attempts.size() > 1) summary["attempts"] = attempts_summary(outcome);
  if (const auto& failure = outcome.result.failure)
    summary["failure"] = {{"time_s", number(outcome.measurements.start + failure->time)},
                          {"outcome", to_string(failure->outcome)},
                          {"cause", failure->cause},
                          {"subject", failure->subject},
                          {"remedy", failure->remedy},
                          {"samples", failure->computed}};
  if (outcome.robust.rank > 0)
    summary["robust"] = {
        {"method", robust_method(outcome.robust)},
        {"bandwidth_samples", number(outcome.robust.bandwidth * outcome.result.unknowns_history.stride)},
        {"rank", outcome.robust.rank},
        {"condition", number(outcome.robust.condition)}};
  if (outcome.reductions > 0 || outcome.result.linearisations > 0)
    summary["linear_unknowns"] = {{"linearisations", outcome.result.linearisations},
                                  {"reductions", outcome.reductions}};
  if (const auto states = errors_by_point(outcome.points, outcome.settled); !states.empty()) summary["states"] = states;
  if (outcome.open_loop) summary["open_loop"] = open_loop_summary(outcome);
  if (!outcome.open_loop_failure.empty()) summary["open_loop_failure"] = outcome.open_loop_failure;
  return summary;
}

Json smoothed_summary(const EstimationOutcome& outcome) {
  Json summary = {{"states", errors_by_point(outcome.smoothed_points, outcome.settled)}};
  if (!outcome.smoothed_inputs.empty()) summary["inputs"] = inputs_summary(outcome.smoothed_inputs, outcome.settled);
  return summary;
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
  const auto& [held_back, own] = outcome;
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
  }
  return timing;
}

/// Nothing where the step was not halved.
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

/// What was wrong with the record or missing in it, and a change of an unknown, with their times.
Json events_summary(const RecordEstimate& estimate) {
  Json all = Json::array();
  for (const auto& event : estimate.events) {
    const bool jump = event.kind == EventKind::jump;
    Json each{{"kind", to_string(event.kind)},
              {"channel", event.channel.empty() || jump ? Json(nullptr) : Json(event.channel)},
              {"from", number(event.from)},
              {"to", number(event.to)},
              {"count", event.count},
              {"text", event.text}};
    if (jump) {
      each["unknown"] = event.channel;
      each["before"] = number(estimate.jump->before);
      each["after"] = number(estimate.jump->after);
      each["change_std"] = number(estimate.jump->deviation);
    }
    all.push_back(std::move(each));
  }
  return all;
}

/// Every mistake that was tested, best explanation first.
Json diagnosis_summary(const Diagnosis& diagnosis) {
  Json tested = Json::array();
  for (const auto& each : diagnosis.tested)
    tested.push_back({{"code", each.code},
                      {"subject", each.subject},
                      {"text", each.words},
                      {"value", number(each.value)},
                      {"failed", each.failed},
                      {"log_likelihood_gain", each.failed ? Json(nullptr) : number(each.gain)},
                      {"mean_nis", each.failed ? Json(nullptr) : number(each.mean_nis)}});
  return {{"duration", number(diagnosis.duration)}, {"tested", tested}};
}

}  // namespace

Json summarise(const Study& study, const StudyResults& results) {
  Json summary = {{"kalfem", version},
                  {"run", ""},
                  {"case", std::filesystem::path(study.file).filename().string()},
                  {"title", study.title},
                  {"status", results.usable() ? "ok" : "unusable"},
                  {"message", results.why_unusable()},
                  {"verdict", verdict_summary(results.verdict)},
                  {"model", model_summary(study, results)}};
  std::vector<std::string> warnings = study.warnings;
  warnings.insert(warnings.end(), results.warnings.begin(), results.warnings.end());
  if (!warnings.empty()) summary["warnings"] = warnings;
  if (results.simulation)
    summary["simulation"] = {{"steps_per_sample", results.simulation->reference.substeps},
                             {"extrapolations", results.simulation->reference.extrapolations},
                             {"fixed_step", study.simulation->has_fixed_step()},
                             {"last_change", last_change(study, results.simulation->reference)}};
  if (study.record) summary["record"] = record_summary(study, results);
  if (results.estimation) {
    summary["parameters"] = parameters_summary(study, *results.estimation);
    if (!results.estimation->inputs.empty()) {
      summary["inputs"] = inputs_summary(results.estimation->inputs, results.estimation->settled);
      summary["hardly_known"] = results.estimation->hardly_known;
    }
    summary["estimation"] = estimation_summary(*results.estimation);
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
