// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/infer.hpp"

#include <algorithm>

#include "kalfem/api/inference_question.hpp"
#include "kalfem/inference/infer.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

constexpr double share_of_filter = 0.1;  ///< of the time, for the estimates from which the search begins

}  // namespace

InferResult result_of(InferenceResult found) {
  const Index count = found.samples.values.cols();
  InferResult result{.parameters = posterior_parameters(found.units, found.prior, found.posterior, found.most_probable),
                     .samples = std::move(found.samples.values),
                     .weights = std::move(found.samples.weights),
                     .log_likelihood = std::move(found.samples.log_likelihood),
                     .log_prior = std::move(found.samples.log_prior),
                     .chains = found.samples.chains,
                     .correlation = std::move(found.correlation),
                     .log_evidence = found.log_evidence,
                     .log_evidence_std = found.log_evidence_deviation,
                     .method = std::move(found.method),
                     .likelihood = std::move(found.likelihood),
                     .effective_samples = found.effective_samples,
                     .pareto_k = found.pareto_k,
                     .evaluations = found.evaluations,
                     .modes = std::move(found.modes),
                     .warnings = std::move(found.warnings)};
  for (std::size_t i = 0; i < found.convergence.size(); ++i) {
    result.parameters[i].r_hat = found.convergence[i].r_hat;
    result.parameters[i].effective_samples = found.convergence[i].bulk_ess;
  }
  if (result.weights.size() == 0) result.weights.setConstant(count, 1.0 / static_cast<double>(count));
  if (found.before) result.foreseen = found.before->text;
  if (found.after) result.identifiability = found.after->text;
  for (auto& each : found.profiles)
    result.profiles.push_back({each.name, each.unit, each.values, each.log_likelihood, each.lower, each.upper});
  for (auto& each : found.bands)
    result.bands.push_back({each.sensor, each.unit, each.mean, each.lower, each.upper, each.coverage});
  return result;
}

std::vector<PosteriorParameter> posterior_parameters(const std::vector<std::string>& units,
                                                     const std::vector<ParameterSummary>& prior,
                                                     const std::vector<ParameterSummary>& posterior,
                                                     const Eigen::VectorXd& most_probable) {
  std::vector<PosteriorParameter> parameters;
  for (std::size_t i = 0; i < prior.size(); ++i) {
    PosteriorParameter parameter{.name = prior[i].name,
                                 .unit = units[i],
                                 .most_probable = most_probable[static_cast<Index>(i)],
                                 .prior_mean = prior[i].mean,
                                 .prior_std = prior[i].deviation};
    if (i < posterior.size()) {
      parameter.mean = posterior[i].mean;
      parameter.std = posterior[i].deviation;
      parameter.median = posterior[i].median;
      parameter.interval_68 = {posterior[i].q16, posterior[i].q84};
      parameter.interval_95 = {posterior[i].q2_5, posterior[i].q97_5};
    }
    parameters.push_back(std::move(parameter));
  }
  return parameters;
}

const PosteriorParameter& InferResult::parameter(const std::string& name) const {
  const auto found = std::ranges::find(parameters, name, &PosteriorParameter::name);
  if (found != parameters.end()) return *found;
  std::vector<std::string> known;
  for (const auto& each : parameters) known.push_back(each.name);
  throw InvalidInput("the result has no parameter '" + name + "'" + did_you_mean(name, known), "", "");
}

InferResult infer(const Structure& structure, const Record& record, const InferOptions& options) {
  const auto [problem, measured] = make_inference_question(structure, record, options);
  const RecordEstimate estimate = estimate_record(problem.problem, problem.setup, measured,
                                                  {.progress = part_of(options.progress, 0.0, share_of_filter)});
  return result_of(
      infer(problem, measured, {.estimate = &estimate, .progress = part_of(options.progress, share_of_filter, 1.0)}));
}

}  // namespace kalfem
