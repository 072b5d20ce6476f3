// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/inference/report.hpp"

#include <fmt/format.h>

#include "kalfem/page/json_number.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/sampling/peak_search.hpp"
#include "kalfem/steps/inference/outcome.hpp"

namespace kalfem {

using Eigen::Index;
using Json = nlohmann::ordered_json;

namespace {

Json parameter_json(const InferredValues& values) {
  const auto& [name, unit, prior, posterior, truth, most_probable, convergence] = values;
  Json json = {{"mean", nullptr}, {"std", nullptr}, {"quantiles", nullptr}, {"prior", nullptr}};
  if (posterior) {
    json["mean"] = number(posterior->mean);
    json["std"] = number(posterior->deviation);
    json["quantiles"] = {{"2.5%", number(posterior->q2_5)},
                         {"16%", number(posterior->q16)},
                         {"50%", number(posterior->median)},
                         {"84%", number(posterior->q84)},
                         {"97.5%", number(posterior->q97_5)}};
  }
  if (prior) json["prior"] = {{"mean", number(prior->mean)}, {"std", number(prior->deviation)}};
  json["most_probable"] = number(most_probable);
  json["true"] = number(truth);
  json["unit"] = unit;
  if (truth) json["z"] = number(values.z());
  if (convergence) {
    json["r_hat"] = number(convergence->r_hat);
    json["ess_bulk"] = number(convergence->bulk_ess);
    json["ess_tail"] = number(convergence->tail_ess);
  }
  return json;
}

Json identifiability_json(const std::optional<Identifiability>& judged) {
  if (!judged) return nullptr;
  Json bounds = Json::object(), combinations = Json::array();
  for (Index i = 0; i < judged->cramer_rao.size(); ++i)
    bounds[judged->parameters[static_cast<std::size_t>(i)].name] = number(judged->cramer_rao[i]);
  for (const auto& combination : judged->combinations)
    combinations.push_back({{"words", combination.words},
                            {"deviation", number(combination.deviation)},
                            {"determined", combination.determined}});
  return {{"text", judged->text}, {"cramer_rao", bounds}, {"combinations", combinations}};
}

Json correlation_json(const InferenceOutcome& outcome) {
  Json names = Json::array(), matrix = Json::array();
  for (const auto& parameter : outcome.posterior) names.push_back(parameter.name);
  for (Index i = 0; i < outcome.correlation.rows(); ++i)
    matrix.push_back(numbers(outcome.correlation.row(i).transpose()));
  return {{"names", names}, {"matrix", matrix}};
}

Json modes_json(const InferenceOutcome& outcome) {
  Json modes = Json::array();
  for (const auto& mode : outcome.modes) {
    Json parameters = Json::object();
    for (Index i = 0; i < mode.mean.size(); ++i)
      parameters[outcome.posterior[static_cast<std::size_t>(i)].name] = {
          {"mean", number(mode.mean[i])}, {"std", number(mode.deviation[i])}, {"most_probable", number(mode.peak[i])}};
    modes.push_back({{"weight", number(mode.weight)}, {"parameters", parameters}});
  }
  return modes;
}

Json filter_json(const std::vector<FilterComparison>& comparisons) {
  Json json = Json::object();
  for (const auto& each : comparisons)
    json[each.name] = {{"filter_mean", number(each.filter_mean)},
                       {"filter_std", number(each.filter_deviation)},
                       {"mean_difference", number(each.mean_difference)},
                       {"std_ratio", number(each.deviation_ratio)},
                       {"agrees", each.agrees()}};
  return json;
}

Json profiles_json(const std::vector<ProfileLikelihood>& profiles) {
  Json json = Json::object();
  for (const auto& each : profiles)
    json[each.name] = {{"values", numbers(each.values)},
                       {"log_likelihood", numbers(each.log_likelihood)},
                       {"interval_95", {number(each.lower), number(each.upper)}}};
  return json;
}

Json law_json(const RankedLaw& law) {
  const bool has_evidence = law.failure.empty();
  const auto known = [&](double value) { return has_evidence ? number(value) : Json(nullptr); };
  Json parameters = Json::object();
  for (std::size_t i = 0; i < law.posterior.size(); ++i)
    parameters[law.posterior[i].name] = {{"mean", number(law.posterior[i].mean)},
                                         {"std", number(law.posterior[i].deviation)},
                                         {"unit", i < law.units.size() ? law.units[i] : ""}};
  return {{"name", law.name},
          {"law", law.law},
          {"log_evidence", known(law.log_evidence)},
          {"log_evidence_std", known(law.log_evidence_deviation)},
          {"probability", known(law.probability)},
          {"occam", known(law.occam)},
          {"log_likelihood", known(law.log_likelihood)},
          {"words", law.words},
          {"parameters", parameters},
          {"validation",
           {{"log_density", number(law.validation)},
            {"one_step_nrmse", number(law.validation_one_step)},
            {"open_loop_nrmse", number(law.validation_open_loop)}}},
          {"warnings", law.warnings},
          {"failure", has_evidence ? Json(nullptr) : Json(law.failure)}};
}

Json laws_json(const LawRanking& ranking) {
  Json laws = Json::array();
  for (const auto& law : ranking.laws) laws.push_back(law_json(law));
  return {{"connector", ranking.connector}, {"ranking", laws}};
}

Json sensitivity_json(const InferenceOutcome& outcome) {
  const auto parameters = inferred_values(outcome);
  const auto indices_json = [&](const std::vector<SobolIndex>& indices) {
    Json json = Json::object();
    for (std::size_t i = 0; i < std::min(indices.size(), parameters.size()); ++i)
      json[parameters[i].name] = {{"value", number(indices[i].value)},
                                  {"lower", number(indices[i].lower)},
                                  {"upper", number(indices[i].upper)}};
    return json;
  };
  Json json = Json::object();
  for (const auto& each : outcome.sensitivity)
    json[each.output] = {{"first", indices_json(each.indices.first)}, {"total", indices_json(each.indices.total)}};
  return json;
}

}  // namespace

Json inference_summary(const InferenceOutcome& outcome) {
  const bool sampled = outcome.samples.values.cols() > 0;
  Json parameters = Json::object(), predictive = Json::object();
  for (const auto& values : inferred_values(outcome)) parameters[values.name] = parameter_json(values);
  for (const auto& band : outcome.bands) predictive[band.sensor] = {{"coverage_95", number(band.coverage)}};
  Json summary = {{"likelihood", outcome.likelihood},
                  {"method", outcome.method},
                  {"parameters", parameters},
                  {"correlation", correlation_json(outcome)},
                  {"log_evidence", number(outcome.log_evidence)},
                  {"log_evidence_std", number(outcome.log_evidence_deviation)},
                  {"log_evidence_substep_bias", number(outcome.substep_bias)},
                  {"modes", modes_json(outcome)},
                  {"prior_starts", outcome.prior_starts ? Json(*outcome.prior_starts) : Json(nullptr)},
                  {"unseen_share", outcome.prior_starts ? number(unseen_share(*outcome.prior_starts)) : Json(nullptr)},
                  {"log_likelihood", sampled ? number(outcome.log_likelihood) : Json(nullptr)},
                  {"samples", outcome.samples.values.cols()},
                  {"effective_samples", number(outcome.effective_samples)},
                  {"pareto_k", number(outcome.pareto_k)},
                  {"evaluations", outcome.evaluations},
                  {"identifiability",
                   {{"before", identifiability_json(outcome.before)}, {"after", identifiability_json(outcome.after)}}},
                  {"beside_filter", filter_json(outcome.beside_filter)},
                  {"profiles", profiles_json(outcome.profiles)},
                  {"predictive", predictive},
                  {"laws", outcome.laws ? laws_json(*outcome.laws) : Json(nullptr)},
                  {"sensitivity", sensitivity_json(outcome)},
                  {"warnings", outcome.warnings},
                  {"seconds", number(outcome.seconds)}};
  return summary;
}

std::string console_inference(const InferenceOutcome& outcome) {
  std::string text = inference_answer(outcome) + "\n";
  for (const auto& warning : inference_warnings(outcome)) text += "Warning: " + warning + "\n";
  text += inference_method_words(outcome) + "\n";
  const auto add = [&text](const Table& table) {
    if (!table.rows.empty()) text += "\n" + table.title + "\n" + to_text(table);
  };
  const auto add_line = [&text](const std::string& line) {
    if (!line.empty()) text += line + "\n";
  };
  add(posterior_table(outcome));
  add(mode_table(outcome));
  add(convergence_table(outcome));
  add(posterior_correlation_table(outcome));
  add(identifiability_table(outcome));
  if (outcome.before) add_line("Expected at the prior's centre: " + outcome.before->text);
  if (outcome.after) add_line(after_words(outcome));
  add(filter_table(outcome));
  add_line(filter_words(outcome));
  add(profile_table(outcome));
  add(coverage_table(outcome));
  if (outcome.laws) add(law_table(*outcome.laws));
  for (const auto& each : outcome.sensitivity) add(sobol_table(outcome, each));
  return text + "\n";
}

}  // namespace kalfem
