// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/inference_plan.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/identification/expected_record.hpp"
#include "kalfem/identification/unknown_prior.hpp"
#include "kalfem/inference/marginalised_numbers.hpp"
#include "kalfem/study/case_study.hpp"
#include "kalfem/study/law_alternatives.hpp"
#include "kalfem/study/stated_prior.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

namespace d = description;

/// With a standard deviation a normal one, otherwise the same density between the bounds.
MarginalPrior prior_of(const UpdatingParameter& parameter) {
  if (std::isfinite(parameter.deviation))
    return NormalPrior{parameter.initial, parameter.deviation, parameter.lower, parameter.upper};
  return UniformPrior{parameter.lower, parameter.upper};
}

/// The parameters of a case that can be inferred, in the order of its file, with the priors that it gives elsewhere.
class ParameterList {
public:
  ParameterList(const CaseStudy& study, const InferencePlan& plan) {
    if (plan.likelihood == LikelihoodKind::comparisons) {
      if (study.updating) add_updated(*study.updating);
    } else if (study.problem) {
      add_unknowns(*study.problem);
    }
  }

  [[nodiscard]] const std::vector<InferredParameter>& parameters() const { return parameters_; }
  [[nodiscard]] Named<MarginalPrior>& priors() { return priors_; }

  /// Keeps those that are named, in the list's order.
  void keep(const std::vector<Name>& names, IssueList& issues) {
    if (names.empty()) return;
    std::vector<bool> kept(parameters_.size(), false);
    for (const auto& name : names)
      if (const auto place = find(name, issues)) kept[*place] = true;
    std::size_t at = 0, of_prior = 0;
    std::erase_if(parameters_, [&](const auto&) { return !kept[at++]; });
    std::erase_if(priors_, [&](const auto&) { return !kept[of_prior++]; });
  }

  [[nodiscard]] std::optional<std::size_t> find(const std::string& name) const {
    const auto place = std::ranges::find(parameters_, name, &InferredParameter::name);
    if (place == parameters_.end()) return std::nullopt;
    return static_cast<std::size_t>(place - parameters_.begin());
  }

  /// The same; an issue with the place of the name where there is none.
  [[nodiscard]] std::optional<std::size_t> find(const Name& name, IssueList& issues) const {
    const auto place = find(name.value);
    if (place) return place;
    std::vector<std::string> names;
    for (const auto& parameter : parameters_) names.push_back(parameter.name);
    issues.add(name.location,
               name.path + ": there is no parameter '" + name.value + "' to infer" + did_you_mean(name.value, names),
               "parameters are the constant unknowns of `estimate`, or those of `update`",
               names.empty() ? "add it there" : "");
    return std::nullopt;
  }

private:
  void add(InferredParameter parameter, MarginalPrior prior) {
    priors_.emplace_back(parameter.name, prior);
    parameters_.push_back(std::move(parameter));
  }

  void add_unknowns(const EstimationProblem& problem) {
    for (const auto& unknown : problem.settings.unknowns)
      if (unknown.random_walk == 0.0)
        add({unknown.name, unknown.unit(), unknown.initial, unknown.truth}, kalfem::prior_of(unknown));
    for (const auto& unknown : problem.settings.likelihood_unknowns)
      add({unknown.name, unknown.unit, unknown.initial, unknown.truth}, kalfem::prior_of(unknown));
  }

  void add_updated(const UpdatingSetup& updating) {
    for (std::size_t i = 0; i < updating.parameters.size(); ++i) {
      const auto& parameter = updating.parameters[i];
      add({parameter.name, parameter.unit, parameter.initial, updating.true_parameters[i]}, prior_of(parameter));
    }
  }

  std::vector<InferredParameter> parameters_;
  Named<MarginalPrior> priors_;
};

void set_stated_priors(const d::Inference& given, ParameterList& list, IssueList& issues) {
  for (const auto& [name, prior] : given.priors) {
    const auto place = list.find(Name{name, prior.location, prior.path}, issues);
    if (!place) continue;
    try {
      list.priors()[*place].second = stated_prior(prior, list.parameters()[*place].unit);
    } catch (const InvalidInput& error) {
      issues.add(error, prior.location);
    }
  }
}

/// Each prior must hold the value from which the search starts.
void check_start(const d::Inference& given, const SourceLocation& place, ParameterList& list, IssueList& issues) {
  for (std::size_t i = 0; i < list.parameters().size(); ++i) {
    const auto& parameter = list.parameters()[i];
    IssueList improper;
    check(parameter.name, list.priors()[i].second, improper);
    for (const auto& issue : improper.issues())
      issues.add(place, "infer.priors." + parameter.name + ": " + issue.what, issue.why, issue.fix);
    if (!improper.empty()) continue;
    const auto [lower, upper] = support(list.priors()[i].second);
    if (lower <= parameter.start && parameter.start <= upper) continue;
    const auto own = std::ranges::find(given.priors, parameter.name, &std::pair<std::string, Located<d::Prior>>::first);
    issues.add(own == given.priors.end() ? place : own->second.location,
               "infer.priors." + parameter.name + ": the prior holds " + shortest(lower) + " to " + shortest(upper) +
                   " " + parameter.unit + ", which excludes the initial value " + shortest(parameter.start),
               "the search for the most probable values starts there", "change the initial value or the prior");
  }
}

MatrixXd correlations(const d::Inference& given, const ParameterList& list, IssueList& issues) {
  if (given.correlations.empty()) return {};
  const auto size = std::ssize(list.parameters());
  MatrixXd all = MatrixXd::Identity(size, size);
  for (const auto& [correlation, location, path] : given.correlations) {
    const auto one = list.find(correlation.between[0], issues), other = list.find(correlation.between[1], issues);
    if (!one || !other) continue;
    if (*one == *other)
      issues.add(location, path + ": '" + correlation.between[0].value + "' is named twice",
                 "a correlation is one of two parameters", "name another one");
    all(static_cast<Index>(*one), static_cast<Index>(*other)) =
        all(static_cast<Index>(*other), static_cast<Index>(*one)) = correlation.value;
  }
  return all;
}

/// What the likelihood needs of the case.
void check_likelihood(const CaseStudy& study, const InferencePlan& plan, IssueList& issues) {
  const auto refuse = [&](const std::string& what, const std::string& why, const std::string& fix) {
    issues.add(plan.location, "infer: " + what, why, fix);
  };
  if (plan.likelihood == LikelihoodKind::comparisons) {
    if (!study.updating)
      refuse("there is nothing to infer from: the case has neither `estimate` nor `update`",
             "the likelihood is that of a record or of comparisons", "add one of them");
    return;
  }
  if (!study.problem)
    return refuse("likelihood: filter and simulation need `estimate`", "its unknowns and sensors make the likelihood",
                  "add it, or use likelihood: comparisons with `update`");
  const auto& settings = study.problem->settings;
  if (plan.likelihood == LikelihoodKind::filter) {
    if (settings.adaptive_noise.any())
      refuse("the case asks for adaptive noise",
             "a likelihood is that of one noise, not of one that follows the record",
             "remove estimate.adaptive_noise, or make noise an unknown: sensors.NAME.noise");
    return;
  }
  check_excitation_is_known(*study.problem, issues);
  if (settings.local)
    refuse("the filter has a local model", "a part of a structure cannot be simulated alone",
           "remove estimate.local or use likelihood: filter");
}

/// The filter's own posterior is that of the unknowns in its state, under the priors that it starts from.
void check_filter_method(const CaseStudy& study, const InferencePlan& plan, IssueList& issues) {
  if (plan.method != PosteriorMethod::filter) return;
  const auto& given = study.given.infer->value;
  const std::string fix = "remove it, or take method: importance";
  if (plan.likelihood != LikelihoodKind::filter)
    issues.add(plan.location, "infer: method: filter with another likelihood than the filter's",
               "its posterior is what the filter knows at the record's end", "take method: importance");
  for (const auto& [name, prior] : given.priors)
    issues.add(prior.location, prior.path + ": method: filter starts from the priors of estimate.unknown", "", fix);
  for (const auto& correlation : given.correlations)
    issues.add(correlation.location, correlation.path + ": method: filter starts from independent priors", "", fix);
  if (plan.likelihood == LikelihoodKind::filter && !study.problem->settings.likelihood_unknowns.empty())
    issues.add(plan.location,
               "infer: method: filter, but '" + study.problem->settings.likelihood_unknowns.front().name +
                   "' is not in the filter's state",
               "delays, gains and noise are found by a search, each value with a filter of its own",
               "take method: importance");
}

std::optional<SensitivityOptions> sensitivity_of(const CaseStudy& study, const InferencePlan& plan, IssueList& issues) {
  if (!study.given.infer->value.sensitivity) return std::nullopt;
  const auto& [given, location, path] = *study.given.infer->value.sensitivity;
  SensitivityOptions sensitivity{.samples = given.samples};
  if (plan.likelihood == LikelihoodKind::comparisons)
    issues.add(location, path + ": the unknowns are those of `update`", "outputs depend on the unknowns of `estimate`",
               "remove it");
  if (!study.given.infer->value.correlations.empty())
    issues.add(location, path + ": the priors are correlated", "Sobol' indices are of independent parameters",
               "remove infer.correlations or infer.sensitivity");
  std::vector<std::string> connectors;
  for (const auto& connector : study.model->system().connectors) connectors.push_back(connector.name);
  for (const auto& name : given.outputs) {
    const auto add = [&](SensitivityOptions::Output output) { sensitivity.outputs.push_back(std::move(output)); };
    const std::string kind = name.value.substr(0, name.value.find('.'));
    const std::string of = kind.size() < name.value.size() ? name.value.substr(kind.size() + 1) : "";
    const bool is_number =
        !of.empty() && of.size() < 5 && std::ranges::all_of(of, [](char c) { return c >= '0' && c <= '9'; });
    if (name.value == "nis")
      add({SensitivityOutput::mean_nis, name.value});
    else if (kind == "frequency" && is_number && std::stoi(of) > 0 && std::stoi(of) <= study.model->system().size())
      add({.kind = SensitivityOutput::frequency, .name = name.value, .mode = std::stoi(of) - 1});
    else if (kind == "force" && std::ranges::find(connectors, of) != connectors.end())
      add({.kind = SensitivityOutput::largest_force, .name = name.value, .connector = of});
    else
      issues.add(name.location, name.path + ": there is no output '" + name.value + "'",
                 "outputs are nis, frequency.1 to frequency." + std::to_string(study.model->system().size()) +
                     ", and force.CONNECTOR of a connector of the case",
                 "name one of them");
  }
  return sensitivity;
}

}  // namespace

InferencePlan make_inference_plan(const CaseStudy& study, IssueList& issues) {
  const auto& [given, location, path] = *study.given.infer;
  InferencePlan plan;
  plan.problem = study.problem;
  if (study.augmented_model) plan.setup = *study.augmented_model;
  plan.correlation_time = given.correlation_time;
  plan.method = given.method;
  plan.samples = given.samples;
  plan.predictions = given.predictions;
  plan.seed = given.seed;
  plan.location = location;
  plan.likelihood =
      given.likelihood.value_or(study.given.estimate ? LikelihoodKind::filter : LikelihoodKind::comparisons);
  check_likelihood(study, plan, issues);
  if (issues.empty()) check_filter_method(study, plan, issues);
  if (!issues.empty()) return plan;
  ParameterList list(study, plan);
  const bool none = list.parameters().empty();
  list.keep(given.parameters, issues);
  if (none)
    issues.add(location, "infer: the case has no constant unknown", "there is nothing to infer",
               "add one to estimate.unknown");
  set_stated_priors(given, list, issues);
  if (issues.empty()) check_start(given, location, list, issues);
  MatrixXd correlation = correlations(given, list, issues);
  for (const auto& name : given.profile)
    if (const auto place = list.find(name, issues)) plan.profile.push_back(*place);
  plan.sensitivity = sensitivity_of(study, plan, issues);
  plan.parameters = list.parameters();
  if (!issues.empty()) return plan;
  plan.prior = JointPrior(list.priors(), std::move(correlation));
  if (plan.likelihood != LikelihoodKind::comparisons) marginalise_stated_numbers(plan, issues);
  if (given.laws) add_law_alternatives(study, plan, issues);
  return plan;
}

}  // namespace kalfem
