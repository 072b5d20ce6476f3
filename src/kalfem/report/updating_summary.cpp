#include "kalfem/report/updating_summary.hpp"

#include <cmath>

#include "kalfem/report/json_number.hpp"
#include "kalfem/report/updating_tables.hpp"

namespace kalfem {

using Eigen::Index;
using Json = nlohmann::ordered_json;

namespace {

Json numbers(const Eigen::Ref<const Eigen::VectorXd>& values) {
  Json list = Json::array();
  for (const double value : values) list.push_back(number(value));
  return list;
}

const char* name_of(Seen seen) {
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

Json parameters_of(const Study& study, const UpdatingStage& stage) {
  Json all = Json::object();
  const auto& [deviations, covariance, correlation, to_prior, freedom, chi, widening, seen, blind, pairs, at_bound] =
      stage.statistics;
  for (std::size_t i = 0; i < study.updating->parameters.size(); ++i) {
    const auto& parameter = study.updating->parameters[i];
    const auto index = static_cast<Index>(i);
    Json& own = all[parameter.name];
    own = {{"true", number(study.updating->true_parameters[i])},
           {"initial", number(parameter.initial)},
           {"estimate", number(stage.values[index])},
           {"std", index < deviations.size() ? number(deviations[index]) : Json(nullptr)},
           {"unit", parameter.unit},
           {"lower", number(parameter.lower)},
           {"upper", number(parameter.upper)},
           {"prior_std", number(parameter.deviation)}};
    if (i < seen.size()) own["informed"] = name_of(seen[i]);
    if (i < at_bound.size() && at_bound[i]) own["at_bound"] = true;
  }
  return all;
}

Json modes_of(const std::vector<PairedMode>& modes) {
  Json list = Json::array();
  for (const auto& mode : modes)
    list.push_back({{"measured_hz", number(mode.measured_frequency)},
                    {"model_hz", mode.model_mode ? number(mode.model_frequency) : Json(nullptr)},
                    {"error", mode.model_mode ? number(mode.relative_error) : Json(nullptr)},
                    {"mac", number(mode.mac)}});
  return list;
}

Json comparisons_of(const UpdatingStage& stage) {
  Json all = Json::object();
  for (const auto& each : stage.comparisons) {
    Json& own = all[each.name];
    own = {{"of", each.kind},
           {"values", each.size},
           {"weight", number(each.weight)},
           {"rms_initial", number(each.rms_initial)},
           {"rms_final", number(each.rms_final)}};
    for (const auto& response : each.responses)
      if (response.scale) own["scales"][response.name] = number(*response.scale);
    if (each.modes_final.empty()) continue;
    own["mean_frequency_error_initial"] = number(mean_frequency_error(each.modes_initial));
    own["mean_frequency_error_final"] = number(mean_frequency_error(each.modes_final));
    own["modes"] = modes_of(each.modes_final);
  }
  return all;
}

Json trace_of(const UpdatingStage& stage) {
  Json list = Json::array();
  for (const auto& step : stage.trace)
    list.push_back({{"residual", number(step.residual)},
                    {"accepted", step.accepted},
                    {"tried", numbers(step.tried)},
                    {"seconds", number(step.seconds)}});
  return list;
}

Json sensitivities_of(const UpdatingStage& stage) {
  Json all = Json::object();
  for (const auto& each : stage.sensitivities)
    all[each.parameter] = {{"deviation", number(each.deviation)},
                           {"uncertainty", number(each.uncertainty)},
                           {"verdict", words(each.verdict)}};
  return all;
}

}  // namespace

Json updating_summary(const Study& study, const UpdatingStage& stage) {
  Json summary = {{"parameters", parameters_of(study, stage)},
                  {"iterations", stage.iterations},
                  {"evaluations", stage.evaluations},
                  {"residual_initial", number(stage.residual_initial)},
                  {"residual_final", number(stage.residual_final)},
                  {"converged", stage.converged},
                  {"termination", stage.termination},
                  {"method", stage.method},
                  {"remarks", stage.remarks},
                  {"comparisons", comparisons_of(stage)}};
  if (stage.statistics.reduced_chi_squared)
    summary["reduced_chi_squared"] = number(*stage.statistics.reduced_chi_squared);
  Json correlation = Json::array(), covariance = Json::array();
  for (Index i = 0; i < stage.statistics.correlation.rows(); ++i) {
    correlation.push_back(numbers(stage.statistics.correlation.row(i).transpose()));
    covariance.push_back(numbers(stage.statistics.covariance.row(i).transpose()));
  }
  summary["correlation"] = correlation;
  summary["covariance"] = covariance;
  summary["stages"] = trace_of(stage);
  if (stage.resumed_at > 0) summary["resumed_at"] = stage.resumed_at;
  if (!stage.sensitivities.empty()) summary["sensitivities"] = sensitivities_of(stage);
  if (stage.unknowns_before.size() > 0) {
    Json before = Json::object();
    const auto& unknowns = study.observer->options.unknowns;
    for (std::size_t i = 0; i < unknowns.size(); ++i)
      before[unknowns[i].name] = number(stage.unknowns_before[static_cast<Index>(i)]);
    summary["unknowns_without_updating"] = before;
  }
  return summary;
}

}  // namespace kalfem
