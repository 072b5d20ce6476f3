// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/estimation/report.hpp"

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "kalfem/diagnosis/judge_estimation.hpp"
#include "kalfem/identification/stated_interval.hpp"
#include "kalfem/identification/walked_range.hpp"
#include "kalfem/page/json_number.hpp"
#include "kalfem/steps/point_errors.hpp"

namespace kalfem {

using Json = nlohmann::ordered_json;

namespace {

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

}  // namespace

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
                                {"std_considered", number(considered_deviation(outcome, i))},
                                {"interval_95", {number(interval.lower), number(interval.upper)}},
                                {"interval_95_from", interval.considered ? "std_considered"
                                                     : interval.robust   ? "std_robust"
                                                                         : "std"},
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

namespace {

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
                  {"fraction_in_95", number(consistency.fraction_in_95)},
                  {"judged_samples", outcome.measurements.samples() - outcome.settled}};
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

}  // namespace

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
  summary["step_order"] = outcome.augmented_model->options().step_order;
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

Json events_summary(const RecordEstimate& estimate) {
  Json all = Json::array();
  for (const auto& event : estimate.events) {
    const bool change = event.is_change();
    Json each{{"kind", to_string(event.kind)},
              {"channel", event.channel.empty() || change ? Json(nullptr) : Json(event.channel)},
              {"from", number(event.from)},
              {"to", number(event.to)},
              {"count", event.count},
              {"text", event.text}};
    if (change) {
      each["unknown"] = event.channel;
      each["before"] = number(estimate.jump->before);
      each["after"] = number(estimate.jump->after);
      each["change_std"] = number(estimate.jump->deviation);
    }
    all.push_back(std::move(each));
  }
  return all;
}

Json tested_summary(const std::vector<TestedHypothesis>& mistakes) {
  Json all = Json::array();
  for (const auto& each : mistakes)
    all.push_back({{"code", each.code},
                   {"subject", each.subject},
                   {"text", each.words},
                   {"value", number(each.value)},
                   {"failed", each.failed},
                   {"log_likelihood_gain", each.failed ? Json(nullptr) : number(each.gain)},
                   {"mean_nis", each.failed ? Json(nullptr) : number(each.mean_nis)}});
  return all;
}

Json diagnosis_summary(const Diagnosis& diagnosis) {
  Json summary = {{"duration", number(diagnosis.duration)}, {"tested", tested_summary(diagnosis.tested)}};
  if (!diagnosis.together.empty()) summary["together"] = tested_summary(diagnosis.together);
  return summary;
}

}  // namespace kalfem
