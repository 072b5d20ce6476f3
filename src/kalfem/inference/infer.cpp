// SPDX-License-Identifier: Apache-2.0
#include "kalfem/inference/infer.hpp"

#include <fmt/format.h>

#include "kalfem/base/stopwatch.hpp"
#include "kalfem/identification/expected_record.hpp"
#include "kalfem/identification/filter_likelihood.hpp"
#include "kalfem/identification/fisher_information.hpp"
#include "kalfem/inference/filter_posterior.hpp"
#include "kalfem/inference/marginalised_numbers.hpp"
#include "kalfem/inference/output_sensitivity.hpp"
#include "kalfem/inference/predictive_bands.hpp"
#include "kalfem/inference/sample_posterior.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// The parameters and their priors, before any data.
InferenceResult result_before(const InferenceProblem& problem) {
  InferenceResult result;
  result.prior = summarise_prior(problem.prior);
  for (const auto& [name, marginal] : problem.prior.marginals()) result.prior_marginals.push_back(marginal);
  for (const auto& parameter : problem.parameters) {
    result.units.push_back(parameter.unit);
    result.truths.push_back(parameter.truth);
  }
  return result;
}

std::vector<InformedParameter> informed(const InferenceProblem& problem, const VectorXd& values) {
  const VectorXd deviation = problem.prior.deviation();
  std::vector<InformedParameter> parameters;
  for (Index i = 0; i < values.size(); ++i)
    parameters.push_back({problem.parameters[static_cast<std::size_t>(i)].name, values[i], deviation[i]});
  return parameters;
}

std::optional<Identifiability> judged(const InferenceProblem& problem,
                                      const std::optional<Eigen::MatrixXd>& information, const VectorXd& theta) {
  if (!information || !information->allFinite()) return std::nullopt;
  return identifiability(*information, informed(problem, theta));
}

std::vector<ProfileLikelihood> profiles_of(const InferenceProblem& problem, const ParameterLikelihood& likelihood,
                                           const InferenceResult& result) {
  VectorXd deviation(std::ssize(result.posterior));
  for (Index i = 0; i < deviation.size(); ++i) deviation[i] = result.posterior[static_cast<std::size_t>(i)].deviation;
  std::vector<ProfileLikelihood> profiles;
  for (const std::size_t i : problem.profile) {
    ProfileLikelihood profile;
    static_cast<Profile&>(profile) =
        profile_likelihood({problem.prior, likelihood.log_likelihood}, static_cast<Index>(i), result.most_probable,
                           deviation, {.threads = problem.threads()});
    profile.name = problem.parameters[i].name;
    profile.unit = problem.parameters[i].unit;
    profiles.push_back(std::move(profile));
  }
  return profiles;
}

/// What follows from samples of the posterior and the likelihood.
void add_conclusions(const InferenceProblem& problem, const ParameterLikelihood& likelihood, InferenceResult& result) {
  result.likelihood = likelihood.words;
  if (result.posterior.empty()) return;
  const VectorXd centre = result.centre();
  result.after = judged(problem, likelihood.information(centre), centre);
  result.profiles = profiles_of(problem, likelihood, result);
}

/// Whether the filter has a normal distribution of its own beside the posterior.
bool has_filter_beside(const InferenceProblem& problem, const RecordEstimate* estimate) {
  return problem.likelihood == LikelihoodKind::filter && problem.method != PosteriorMethod::filter && estimate &&
         !estimate->result.failure;
}

void add_bands(const InferenceProblem& problem, const Record& record, InferenceResult& result) {
  result.bands = predictive_bands(problem, record, result.samples);
  if (result.bands.empty() && problem.predictions > 0 && can_be_simulated(problem))
    result.warnings.push_back(
        fmt::format("predictions: {}: no draw of the posterior could be simulated from rest to the record's end, "
                    "so there are no bands of the response; simulate fewer seconds, or set predictions: 0",
                    problem.predictions));
}

void add_sensitivity(const InferenceProblem& problem, const Record& record, InferenceResult& result) {
  result.sensitivity = output_sensitivity(problem, record);
  const auto left_out = result.sensitivity.empty() ? 0 : result.sensitivity.front().indices.left_out;
  if (left_out > 0)
    result.warnings.push_back(fmt::format(
        "sensitivity: the outputs cannot be computed at {} of {} samples of the priors, which the indices leave out; "
        "narrow the priors to values at which the structure is possible",
        left_out, problem.sensitivity->samples));
}

}  // namespace

std::optional<Identifiability> expected_identifiability(const InferenceProblem& problem, const Record& time) {
  IssueList unknown;
  check_excitation_is_known(*problem.problem, unknown);
  if (!unknown.empty()) return std::nullopt;
  const VectorXd start = start_of(problem);
  const auto expected = expected_record(problem.problem, time, names_of(problem), start);
  if (!expected) return std::nullopt;
  const FilterLikelihood likelihood(problem.problem, *expected, names_of(problem), {.first = start});
  return judged(
      problem,
      fisher_information(likelihood, start, {.scale = problem.prior.deviation(), .threads = problem.threads()}), start);
}

// 1. What the record can tell, before it is looked at.
// 2. The posterior by the problem's method.
// 3. What it says of identifiability, beside the filter, of the record and of outputs.
InferenceResult infer(const InferenceProblem& problem, const Record& record, const InferenceAids& aids) {
  const Stopwatch watch;
  InferenceResult result = result_before(problem);
  result.before = expected_identifiability(problem, record);
  add_conclusions(problem, posterior_of_record(problem, record, aids, result), result);
  if (!result.posterior.empty()) {
    if (has_filter_beside(problem, aids.estimate)) result.beside_filter = beside_filter(result, *aids.estimate);
    add_bands(problem, record, result);
  }
  if (problem.sensitivity) add_sensitivity(problem, record, result);
  drop_marginalised(problem.marginalised, result);
  result.seconds = watch.seconds();
  return result;
}

InferenceResult infer(const InferenceProblem& problem, ParameterLikelihood likelihood, const InferenceAids& aids) {
  const Stopwatch watch;
  InferenceResult result = result_before(problem);
  add_conclusions(problem, posterior_of_data(problem, std::move(likelihood), aids, result), result);
  result.seconds = watch.seconds();
  return result;
}

}  // namespace kalfem
