// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/updating/report.hpp"

#include <fmt/format.h>

#include <cmath>

#include "kalfem/page/json_number.hpp"
#include "kalfem/steps/updating/compute.hpp"
#include "kalfem/updating/parameter_interval.hpp"

namespace kalfem {

using Eigen::Index;
using Json = nlohmann::ordered_json;

namespace {

const char* to_string(Seen seen) {
  switch (seen) {
    case Seen::well:
      return "well";
    case Seen::poorly:
      return "poorly";
    case Seen::not_at_all:
      return "not at all";
    case Seen::held:
      break;
  }
  return "held";
}

Json parameters_of(const Study& study, const UpdatingOutcome& outcome) {
  Json all = Json::object();
  const auto& [deviations, covariance, correlation, to_prior, freedom, chi, variance_inflation, seen, unidentifiable,
               pairs, at_bound, considered] = outcome.statistics;
  const auto& robust = outcome.robust.deviations;
  for (std::size_t i = 0; i < study.updating->parameters.size(); ++i) {
    const auto& parameter = study.updating->parameters[i];
    const auto index = static_cast<Index>(i);
    Json& own = all[parameter.name];
    own = {{"true", number(study.updating->true_parameters[i])},
           {"initial", number(parameter.initial)},
           {"estimate", number(outcome.values[index])},
           {"std", index < deviations.size() ? number(deviations[index]) : Json(nullptr)},
           {"std_robust", index < robust.size() ? number(robust[index]) : Json(nullptr)},
           {"interval_95", nullptr},
           {"unit", parameter.unit},
           {"lower", number(parameter.lower)},
           {"upper", number(parameter.upper)},
           {"prior_std", number(parameter.deviation)}};
    if (const auto interval =
            parameter_interval(parameter, index, outcome.values[index], outcome.statistics, outcome.robust)) {
      own["interval_95"] = {number(interval->lower), number(interval->upper)};
      own["interval_95_from"] = interval->considered ? "std_considered" : interval->robust ? "std_robust" : "std";
    }
    if (index < considered.size() && std::isfinite(deviations[index]))
      own["std_considered"] = number(std::hypot(deviations[index], considered[index]));
    if (i < seen.size()) own["informed"] = to_string(seen[i]);
    if (i < at_bound.size() && at_bound[i]) own["at_bound"] = true;
  }
  return all;
}

Json robust_of(const RobustStatistics& robust) {
  if (!robust.exist()) return {{"method", "none: " + robust.none}};
  return {{"method", robust.method},
          {"degrees_of_freedom", number(robust.degrees_of_freedom)},
          {"bandwidth_steps", number(robust.bandwidth)},
          {"clusters", robust.parts},
          {"rank", robust.rank},
          {"condition", number(robust.condition)}};
}

Json modes_of(const std::vector<PairedMode>& modes) {
  Json list = Json::array();
  for (const auto& mode : modes) {
    list.push_back({{"measured_hz", number(mode.measured_frequency)},
                    {"model_hz", mode.model_mode ? number(mode.model_frequency) : Json(nullptr)},
                    {"error", mode.model_mode ? number(mode.relative_error) : Json(nullptr)},
                    {"mac", number(mode.mac)}});
    if (mode.complexity > 0.0) list.back()["complexity"] = number(mode.complexity);
    if (!mode.measured_damping) continue;
    list.back()["measured_damping"] = number(*mode.measured_damping);
    list.back()["model_damping"] = mode.model_damping ? number(*mode.model_damping) : Json(nullptr);
  }
  return list;
}

/// Steps per sample of a simulation of the record; nothing for other comparisons.
std::optional<Index> substeps_of(const Study& study, const std::string& comparison) {
  for (const auto& each : study.updating_plan->record_comparisons)
    if (const auto* simulated = std::get_if<RecordComparison::OfSimulation>(&each.what);
        simulated && each.name == comparison)
      return simulated->options.substeps;
  return std::nullopt;
}

Json comparisons_of(const Study& study, const UpdatingOutcome& outcome) {
  Json all = Json::object();
  for (const auto& each : outcome.comparisons) {
    Json& own = all[each.name];
    own = {{"of", each.kind},
           {"values", each.size},
           {"weight", number(each.weight)},
           {"rms_initial", number(each.rms_initial)},
           {"rms_final", number(each.rms_final)}};
    if (!each.derivatives.empty()) own["derivatives"] = each.derivatives;
    if (const auto substeps = substeps_of(study, each.name)) own["substeps"] = *substeps;
    for (const auto& response : each.responses)
      if (response.scale) own["scales"][response.name] = number(*response.scale);
    if (each.modes_final.empty()) continue;
    own["mean_frequency_error_initial"] = number(mean_frequency_error(each.modes_initial));
    own["mean_frequency_error_final"] = number(mean_frequency_error(each.modes_final));
    own["modes"] = modes_of(each.modes_final);
  }
  return all;
}

Json trace_of(const UpdatingOutcome& outcome) {
  Json list = Json::array();
  for (const auto& step : outcome.trace)
    list.push_back({{"residual", number(step.residual)},
                    {"accepted", step.accepted},
                    {"tried", numbers(step.tried)},
                    {"seconds", number(step.seconds)}});
  return list;
}

Json minima_of(const Study& study, const UpdatingOutcome& outcome) {
  Json list = Json::array();
  for (const auto& minimum : outcome.minima) {
    Json values = Json::object();
    for (std::size_t i = 0; i < study.updating->parameters.size(); ++i)
      values[study.updating->parameters[i].name] = number(minimum.parameters[static_cast<Index>(i)]);
    list.push_back({{"cost", number(minimum.cost)},
                    {"residual", number(minimum.residual)},
                    {"starts", minimum.reached},
                    {"converged", minimum.converged},
                    {"parameters", values}});
  }
  return list;
}

/// Stated numbers, the change within what is stated that the data ask for, and what each does to the parameters.
Json considered_of(const Study& study, const Considered& considered) {
  Json all = Json::array();
  const auto& stated = study.updating_plan->stated;
  for (std::size_t i = 0; i < stated.size(); ++i) {
    const auto column = static_cast<Index>(i);
    Json shift = Json::object(), adds = Json::object();
    for (std::size_t j = 0; j < study.updating->parameters.size(); ++j) {
      const auto row = static_cast<Index>(j);
      shift[study.updating->parameters[j].name] = number(considered.shift(row, column) / stated[i].scale);
      adds[study.updating->parameters[j].name] = number(considered.by_number(row, column));
    }
    all.push_back({{"name", stated[i].name},
                   {"group", group_of(stated[i].kind)},
                   {"unit", stated[i].unit},
                   {"value", number(stated[i].value)},
                   {"known_to", number(stated[i].deviation * stated[i].scale)},
                   {"allowed_change", number(considered.allowed[column] * stated[i].scale)},
                   {"shift", shift},
                   {"adds", adds}});
  }
  return all;
}

Json sensitivities_of(const UpdatingOutcome& outcome) {
  Json all = Json::object();
  for (const auto& each : outcome.sensitivities)
    all[each.parameter] = {{"deviation", number(each.deviation)},
                           {"uncertainty", number(each.uncertainty)},
                           {"verdict", explain(each.verdict)}};
  return all;
}

/// What the comparisons tell at the initial values: sensitivities by mode, and groups that they determine.
Json before_of(const Study& study, const FirstInformation& first) {
  const auto& parameters = study.updating->parameters;
  Json own = {{"frequencies", Json::object()}, {"undetermined", first.remarks}, {"groups", Json::array()}};
  const auto name = [&](Index i) { return parameters[static_cast<std::size_t>(i)].name; };
  for (const auto& each : first.frequencies) {
    Json& comparison = own["frequencies"][each.comparison];
    comparison["measured_hz"] = numbers(each.measured);
    for (Index j = 0; j < each.relative.cols(); ++j)
      comparison["d_ln_f_d_ln_parameter"][name(j)] = numbers(Eigen::VectorXd(each.relative.col(j)));
  }
  for (const auto& group : first.proposal.groups) {
    own["groups"].push_back(Json::array());
    for (const Index i : group) own["groups"].back().push_back(name(i));
  }
  for (const Index i : first.proposal.hold) own["hold"].push_back(name(i));
  return own;
}

Json alternatives_of(const Study& study, const UpdatingOutcome& outcome) {
  Json all = Json::object();
  for (const auto& each : outcome.alternatives) {
    Json& own = all[each.plan->name];
    own = {{"weight", number(each.outcome.weight)}};
    if (!each.failure.empty()) {
      own["failure"] = each.failure;
      continue;
    }
    own["log_evidence"] = number(*each.outcome.log_evidence);
    own["residual_final"] = number(each.outcome.residual_final);
    own["parameters"] = parameters_of(with_alternative(study, *each.plan), each.outcome);
  }
  return all;
}

}  // namespace

Json updating_summary(const Study& study, const UpdatingOutcome& outcome) {
  Json summary = {{"parameters", parameters_of(study, outcome)},
                  {"iterations", outcome.iterations},
                  {"evaluations", outcome.evaluations},
                  {"residual_initial", number(outcome.residual_initial)},
                  {"residual_final", number(outcome.residual_final)},
                  {"converged", outcome.converged},
                  {"termination", outcome.termination},
                  {"method", outcome.method},
                  {"remarks", outcome.remarks},
                  {"before", before_of(study, outcome.first)},
                  {"comparisons", comparisons_of(study, outcome)}};
  if (outcome.statistics.reduced_chi_squared)
    summary["reduced_chi_squared"] = number(*outcome.statistics.reduced_chi_squared);
  if (outcome.robust.deviations.size() > 0) summary["robust"] = robust_of(outcome.robust);
  if (outcome.log_evidence) summary["log_evidence"] = number(*outcome.log_evidence);
  if (!outcome.alternatives.empty()) {
    summary["weight"] = number(outcome.weight);
    summary["alternatives"] = alternatives_of(study, outcome);
  }
  if (outcome.considered) summary["considered"] = considered_of(study, *outcome.considered);
  Json correlation = Json::array(), covariance = Json::array();
  for (Index i = 0; i < outcome.statistics.correlation.rows(); ++i) {
    correlation.push_back(numbers(outcome.statistics.correlation.row(i).transpose()));
    covariance.push_back(numbers(outcome.statistics.covariance.row(i).transpose()));
  }
  summary["correlation"] = correlation;
  summary["covariance"] = covariance;
  summary["stages"] = trace_of(outcome);
  if (!outcome.minima.empty()) summary["minima"] = minima_of(study, outcome);
  if (outcome.resumed_at > 0) summary["resumed_at"] = outcome.resumed_at;
  if (!outcome.sensitivities.empty()) summary["sensitivities"] = sensitivities_of(outcome);
  if (outcome.unknowns_before.size() > 0) {
    Json before = Json::object();
    const auto& unknowns = study.augmented_model->options.unknowns;
    for (std::size_t i = 0; i < unknowns.size(); ++i)
      before[unknowns[i].name] = number(outcome.unknowns_before[static_cast<Index>(i)]);
    summary["unknowns_without_updating"] = before;
  }
  return summary;
}

}  // namespace kalfem
