#include "kalfem/report/summary_parts.hpp"

#include <cmath>

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
               pairs, at_bound] = outcome.statistics;
  for (std::size_t i = 0; i < study.updating->parameters.size(); ++i) {
    const auto& parameter = study.updating->parameters[i];
    const auto index = static_cast<Index>(i);
    Json& own = all[parameter.name];
    own = {{"true", number(study.updating->true_parameters[i])},
           {"initial", number(parameter.initial)},
           {"estimate", number(outcome.values[index])},
           {"std", index < deviations.size() ? number(deviations[index]) : Json(nullptr)},
           {"unit", parameter.unit},
           {"lower", number(parameter.lower)},
           {"upper", number(parameter.upper)},
           {"prior_std", number(parameter.deviation)}};
    if (i < seen.size()) own["informed"] = to_string(seen[i]);
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

Json comparisons_of(const UpdatingOutcome& outcome) {
  Json all = Json::object();
  for (const auto& each : outcome.comparisons) {
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

Json trace_of(const UpdatingOutcome& outcome) {
  Json list = Json::array();
  for (const auto& step : outcome.trace)
    list.push_back({{"residual", number(step.residual)},
                    {"accepted", step.accepted},
                    {"tried", numbers(step.tried)},
                    {"seconds", number(step.seconds)}});
  return list;
}

Json sensitivities_of(const UpdatingOutcome& outcome) {
  Json all = Json::object();
  for (const auto& each : outcome.sensitivities)
    all[each.parameter] = {{"deviation", number(each.deviation)},
                           {"uncertainty", number(each.uncertainty)},
                           {"verdict", explain(each.verdict)}};
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
                  {"comparisons", comparisons_of(outcome)}};
  if (outcome.statistics.reduced_chi_squared)
    summary["reduced_chi_squared"] = number(*outcome.statistics.reduced_chi_squared);
  Json correlation = Json::array(), covariance = Json::array();
  for (Index i = 0; i < outcome.statistics.correlation.rows(); ++i) {
    correlation.push_back(numbers(outcome.statistics.correlation.row(i).transpose()));
    covariance.push_back(numbers(outcome.statistics.covariance.row(i).transpose()));
  }
  summary["correlation"] = correlation;
  summary["covariance"] = covariance;
  summary["stages"] = trace_of(outcome);
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
