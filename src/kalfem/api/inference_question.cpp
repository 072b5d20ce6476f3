// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/inference_question.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/api/filter_problem.hpp"
#include "kalfem/api/sensor_record.hpp"
#include "kalfem/api/structure_description.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/identification/unknown_prior.hpp"
#include "kalfem/inference/marginalised_numbers.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

constexpr int fewest_samples = 50;

const MarginalPrior* stated_prior(const InferOptions& options, const std::string& name) {
  const auto found = std::ranges::find(options.priors, name, &std::pair<std::string, MarginalPrior>::first);
  return found == options.priors.end() ? nullptr : &found->second;
}

std::vector<std::string> names_of(const std::vector<UnknownDescription>& unknowns) {
  std::vector<std::string> names;
  for (const auto& unknown : unknowns) names.push_back(unknown.name);
  return names;
}

void check_numbers(const InferOptions& options, IssueList& issues) {
  if (options.unknowns.empty())
    issues.add({}, "unknowns: the list is empty", "a posterior is one of unknown parameters", "give at least one");
  refuse_measurement_unknowns(options.unknowns, issues);
  if (options.samples < fewest_samples)
    issues.add({}, "samples: " + std::to_string(options.samples), "a posterior takes " + std::to_string(fewest_samples),
               "ask for more");
  if (options.predictions < 0)
    issues.add({}, "predictions: " + std::to_string(options.predictions), "it is a number of draws", "0 makes none");
  if (!(options.correlation_time >= 0.0) || !std::isfinite(options.correlation_time))
    issues.add({}, "correlation_time: it is " + shortest(options.correlation_time) + " s", "it must be >= 0", "");
  if (options.likelihood == LikelihoodKind::comparisons)
    issues.add({}, "likelihood: comparisons, with a record", "they are those of an updating",
               "give filter or simulation, or UpdateOptions in the place of the record");
}

/// Names of a list, each an unknown.
void check_names(const char* list, const std::vector<std::string>& names, const std::vector<std::string>& known,
                 IssueList& issues) {
  for (std::size_t i = 0; i < names.size(); ++i)
    if (std::ranges::find(known, names[i]) == known.end())
      issues.add({},
                 std::string(list) + "[" + std::to_string(i) + "]: there is no unknown '" + names[i] + "'" +
                     did_you_mean(names[i], known),
                 "", "");
}

/// Whose names are unknowns, each once, and whose numbers make a distribution.
void check_priors(const InferOptions& options, IssueList& issues) {
  const auto known = names_of(options.unknowns);
  for (std::size_t i = 0; i < options.priors.size(); ++i) {
    const auto& [name, prior] = options.priors[i];
    const std::string place = "priors[" + std::to_string(i) + "] '" + name + "': ";
    if (std::ranges::find(known, name) == known.end())
      issues.add({}, place + "there is no unknown of that name" + did_you_mean(name, known), "", "");
    if (stated_prior(options, name) != &prior) issues.add({}, place + "it is given twice", "", "give it once");
    IssueList improper;
    check(name, prior, improper);
    for (const auto& issue : improper.issues()) issues.add({}, place + issue.what, issue.why, issue.fix);
  }
}

/// The filter's own posterior is that of the unknowns in its state, under the priors that it starts from.
void check_filter_method(const InferOptions& options, IssueList& issues) {
  if (options.method != PosteriorMethod::filter) return;
  if (options.likelihood != LikelihoodKind::filter)
    issues.add({}, "method: filter with another likelihood than the filter's",
               "its posterior is what the filter knows at the record's end", "take method: importance");
  if (!options.priors.empty())
    issues.add({}, "priors: method: filter starts from the priors of `unknowns`", "",
               "leave them out, or take method: importance");
}

bool is_proper(const MarginalPrior& prior) {
  IssueList issues;
  check("", prior, issues);
  return issues.empty();
}

/// The unknowns as the filter starts from them: under a stated prior by its median and deviation.
std::vector<UnknownDescription> started(const InferOptions& options) {
  std::vector<UnknownDescription> unknowns = options.unknowns;
  for (auto& [name, prior] : unknowns) {
    const auto* stated = stated_prior(options, name);
    if (!stated || !is_proper(*stated)) continue;
    if (!prior.initial) prior.initial = from_normal(*stated, 0.0);
    if (prior.std == 0.0) prior.std = deviation(*stated);
    if (!prior.transform && std::holds_alternative<LogNormalPrior>(*stated)) prior.transform = {TransformKind::log};
  }
  return unknowns;
}

EstimateOptions filter_options(const InferOptions& options) {
  return {.sensors = options.sensors,
          .unknowns = started(options),
          .initial_state = options.initial_state,
          .process_noise = options.process_noise,
          .filter = options.filter,
          .substeps = options.substeps,
          .threads = options.threads,
          .initial_state_from_record = options.initial_state_from_record,
          .diagnose = false,
          .known_to = options.known_to};
}

/// The constant unknowns that are asked for, with their priors, which must hold the values at which the search starts.
void set_parameters(const InferOptions& options, InferenceProblem& problem, IssueList& issues) {
  const auto is_asked_for = [&](const Unknown& unknown) {
    return options.parameters.empty() ? unknown.random_walk == 0.0
                                      : std::ranges::find(options.parameters, unknown.name) != options.parameters.end();
  };
  Named<MarginalPrior> priors;
  for (const auto& unknown : problem.problem->settings.unknowns) {
    if (!is_asked_for(unknown)) continue;
    if (unknown.random_walk > 0.0)
      issues.add({}, "parameters: '" + unknown.name + "' has a random walk", "a posterior is one of constants",
                 "leave it out");
    const auto* stated = stated_prior(options, unknown.name);
    const MarginalPrior prior = stated ? *stated : prior_of(unknown);
    const auto [lower, upper] = support(prior);
    if (!(lower <= unknown.initial && unknown.initial <= upper))
      issues.add({},
                 "priors: that of '" + unknown.name + "' holds " + shortest(lower) + " to " + shortest(upper) + " " +
                     unknown.unit() + ", which excludes the initial value " + shortest(unknown.initial),
                 "the search for the most probable values starts there", "change the initial value or the prior");
    problem.parameters.push_back({unknown.name, unknown.unit(), unknown.initial});
    priors.emplace_back(unknown.name, prior);
  }
  if (priors.empty()) issues.add({}, "unknowns: none is constant", "a posterior is one of constants", "");
  issues.raise();
  problem.prior = JointPrior(std::move(priors));
}

void set_profile(const InferOptions& options, InferenceProblem& problem) {
  for (std::size_t i = 0; i < options.profile.size(); ++i) {
    const auto found = std::ranges::find(problem.parameters, options.profile[i], &InferredParameter::name);
    if (found == problem.parameters.end())
      throw InvalidInput("profile[" + std::to_string(i) + "]: '" + options.profile[i] + "' is not inferred",
                         "the filter integrates it out", "name it in `parameters`, or leave it out here");
    problem.profile.push_back(static_cast<std::size_t>(found - problem.parameters.begin()));
  }
}

}  // namespace

InferenceQuestion make_inference_question(const Structure& structure, const Record& record,
                                          const InferOptions& options) {
  IssueList issues;
  check_numbers(options, issues);
  check_names("parameters", options.parameters, names_of(options.unknowns), issues);
  check_names("profile", options.profile, names_of(options.unknowns), issues);
  check_priors(options, issues);
  check_filter_method(options, issues);
  InferenceQuestion question;
  auto& problem = question.problem;
  collect("", issues, [&] { require_signals(structure.description()); });
  collect("", issues, [&] { question.record = record_of_sensors(record, options.sensors); });
  FilterProblem made;
  collect("", issues, [&] { made = make_filter_problem(structure, record.sample_rate, filter_options(options)); });
  issues.raise();
  problem.problem = std::move(made.problem);
  problem.setup = std::move(made.setup);
  set_parameters(options, problem, issues);
  set_profile(options, problem);
  problem.likelihood = options.likelihood;
  problem.correlation_time = options.correlation_time;
  problem.method = options.method;
  problem.samples = options.samples;
  problem.seed = options.seed;
  problem.predictions = options.predictions;
  marginalise_stated_numbers(problem, issues);
  issues.raise();
  return question;
}

}  // namespace kalfem
