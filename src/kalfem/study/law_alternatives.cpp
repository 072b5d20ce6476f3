// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/law_alternatives.hpp"

#include <algorithm>

#include "kalfem/study/case_study.hpp"
#include "kalfem/study/component_parts.hpp"
#include "kalfem/study/estimation_problem_of.hpp"
#include "kalfem/study/stated_prior.hpp"

namespace kalfem {
namespace {

namespace d = description;

/// The connector in a case as it was read; null if there is none.
d::Connector* connector_named(const std::string& name, d::Case& given) {
  if (given.component && name == component_name) return &given.component->value.connector;
  const auto found = std::ranges::find(given.connectors, name, &std::pair<std::string, d::Connector>::first);
  return found == given.connectors.end() ? nullptr : &found->second;
}

std::vector<std::string> connector_names(const d::Case& given) {
  std::vector<std::string> names;
  if (given.component) names.push_back(component_name);
  for (const auto& [name, connector] : given.connectors) names.push_back(name);
  return names;
}

/// The alternative between the same ends.
void put_law(const d::LawAlternative& law, d::Connector& connector) {
  const Name from = connector.from, to = connector.to;
  connector = law.connector;
  connector.from = from;
  connector.to = to;
  for (const auto& [parameter, prior] : law.priors)
    connector.parameters.emplace_back(parameter, centre_of(prior).value);
}

/// Without the initial values of states that the alternative has not: another law has the states that it declares.
void leave_out_states(const d::LawAlternative& law, const std::string& connector, const std::string& former_law,
                      d::Case& given) {
  if (law.connector.law.value == former_law && law.connector.states.empty()) return;
  std::erase_if(given.estimate->initial_connector_states, [&](const auto& each) {
    const std::string prefix = connector + ".";
    return each.first.starts_with(prefix) &&
           std::ranges::find(law.connector.states, each.first.substr(prefix.size()),
                             &std::pair<std::string, d::ExpressionState>::first) == law.connector.states.end();
  });
}

/// Whether an unknown sets a parameter of the connector, and of nothing else.
bool is_of_connector(const std::string& name, const d::Unknown& unknown, const std::string& connector) {
  return std::ranges::all_of(names_of(name, unknown),
                             [&](const Name& target) { return target.value.starts_with(connector + "."); });
}

void put_unknowns(const d::LawAlternative& law, const std::string& connector, d::Case& given) {
  auto& unknowns = given.estimate->unknown;
  std::erase_if(unknowns, [&](const auto& each) { return is_of_connector(each.first, each.second, connector); });
  for (const auto& [parameter, prior] : law.priors) {
    const auto [value, spread] = centre_of(prior);
    const bool positive = std::holds_alternative<d::LogNormalPrior>(prior.value.shape);
    unknowns.emplace_back(
        connector + "." + parameter,
        d::Unknown{.initial = value, .std = spread, .transform = positive ? TransformKind::log : TransformKind::none});
  }
}

void put_priors(const d::LawAlternative& law, const std::string& connector, d::Inference& inference) {
  const bool names_parameters = !inference.parameters.empty();
  std::erase_if(inference.priors, [&](const auto& each) { return each.first.starts_with(connector + "."); });
  std::erase_if(inference.parameters, [&](const Name& each) { return each.value.starts_with(connector + "."); });
  for (const auto& [parameter, prior] : law.priors) {
    const std::string name = connector + "." + parameter;
    if (inference.method != PosteriorMethod::filter) inference.priors.emplace_back(name, prior);
    if (names_parameters) inference.parameters.push_back({name, prior.location, prior.path});
  }
}

d::Case case_with(const d::LawAlternative& law, const std::vector<Name>& connectors, const d::Case& base) {
  d::Case given = base;
  given.estimate->alternatives.reset();
  for (const auto& connector : connectors) {
    d::Connector& place = *connector_named(connector.value, given);
    leave_out_states(law, connector.value, place.law.value, given);
    put_law(law, place);
    put_unknowns(law, connector.value, given);
  }
  given.update.reset();
  given.predict.reset();
  given.place.reset();
  given.modifications.clear();
  return given;
}

d::Case inferred_with(const d::LawAlternative& law, const std::vector<Name>& connectors, const d::Case& base) {
  d::Case given = case_with(law, connectors, base);
  auto& inference = given.infer->value;
  inference.laws.reset();
  inference.profile.clear();
  inference.sensitivity.reset();
  inference.correlations.clear();
  for (const auto& connector : connectors) put_priors(law, connector.value, inference);
  return given;
}

d::Case estimated_with(const d::LawAlternative& law, const std::vector<Name>& connectors, const d::Case& base) {
  d::Case given = case_with(law, connectors, base);
  given.infer.reset();
  given.validate.reset();
  return given;
}

using CaseOfLaw = d::Case (*)(const d::LawAlternative&, const std::vector<Name>&, const d::Case&);

std::vector<LawAlternative> studies_of(const d::LawComparison& comparison, const CaseStudy& study, CaseOfLaw case_of,
                                       IssueList& issues) {
  std::vector<LawAlternative> studies;
  for (const auto& [name, law] : comparison.laws) try {
      auto other = make_study(case_of(law.value, comparison.connectors, *study.description), study.file);
      studies.push_back({name, law.value.connector.law.value, std::make_shared<const Study>(std::move(other))});
    } catch (const InvalidInput& error) {
      for (const auto& issue : error.issues())
        issues.add(issue.location.line > 0 ? issue.location : law.location,
                   "with the law '" + name + "': " + issue.what, issue.why, issue.fix);
    }
  return studies;
}

/// An unknown of one of the connectors must not set a parameter elsewhere.
void check_unshared(const std::string& name, const d::Unknown& unknown, const Name& connector, IssueList& issues) {
  const auto targets = names_of(name, unknown);
  const auto own = std::ranges::count_if(
      targets, [&](const Name& target) { return target.value.starts_with(connector.value + "."); });
  if (own > 0 && own < std::ssize(targets))
    issues.add(connector.location,
               connector.path + ": the unknown '" + name + "' applies to '" + connector.value + "' and to others",
               "it would lose its meaning with another law", "make it an unknown of its own");
}

/// A filter's state is normal, or normal in logarithms.
void check_priors_of_filter(const d::LawAlternative& law, const std::string& otherwise, IssueList& issues) {
  for (const auto& [parameter, prior] : law.priors)
    if (std::holds_alternative<d::UniformPrior>(prior.value.shape) || prior.value.bounds)
      issues.add(prior.location, prior.path + ": a filter has no bounded priors",
                 "its state is normal, or normal in logarithms",
                 "give `normal` or `lognormal` without bounds" + otherwise);
}

/// The laws, and the connectors that they are for.
void check_laws(const d::LawComparison& given, const CaseStudy& study, IssueList& issues) {
  d::Case base = *study.description;
  for (const auto& connector : given.connectors)
    if (!connector_named(connector.value, base)) {
      const auto names = connector_names(base);
      issues.add(connector.location, connector.path + ": there is no connector '" + connector.value + "'" +
                                         did_you_mean(connector.value, names));
    }
  for (const auto& [name, law] : given.laws)
    if (law.value.priors.empty())
      issues.add(law.location, law.path + ": no unknown parameter", "its evidence is that of its unknown parameters",
                 "give `priors` of those that are not known");
}

void check_comparison(const d::LawComparison& given, const SourceLocation& location, const std::string& path,
                      const CaseStudy& study, const InferencePlan& plan, IssueList& issues) {
  if (plan.likelihood != LikelihoodKind::filter)
    issues.add(location, path + ": laws are compared by likelihood: filter",
               "their evidence is that of the record, with the motion integrated out", "remove infer.likelihood");
  check_laws(given, study, issues);
  if (given.laws.size() < 2)
    issues.add(location, path + ".laws: " + std::to_string(given.laws.size()) + " given", "a choice needs two",
               "add the laws that are possible");
  if (plan.method == PosteriorMethod::filter)
    for (const auto& [name, law] : given.laws)
      check_priors_of_filter(law.value, ", or take method: importance", issues);
  if (!study.given.estimate) return;
  for (const auto& [name, unknown] : study.given.estimate->unknown)
    for (const auto& connector : given.connectors) check_unshared(name, unknown, connector, issues);
}

}  // namespace

void add_law_alternatives(const CaseStudy& study, InferencePlan& plan, IssueList& issues) {
  const auto& [given, location, path] = *study.given.infer->value.laws;
  check_comparison(given, location, path, study, plan, issues);
  if (!issues.empty()) return;
  for (const auto& connector : given.connectors) plan.connectors.push_back(connector.value);
  plan.laws = studies_of(given, study, inferred_with, issues);
}

std::vector<LawAlternative> estimated_alternatives(const CaseStudy& study, IssueList& issues) {
  const auto& [given, location, path] = *study.given.estimate->alternatives;
  check_laws(given, study, issues);
  for (const auto& [name, law] : given.laws) check_priors_of_filter(law.value, "", issues);
  for (const auto& [name, unknown] : study.given.estimate->unknown)
    for (const auto& connector : given.connectors) check_unshared(name, unknown, connector, issues);
  if (study.given.update)
    issues.add(location, path + ": the case has `update` too",
               "its parameters would be those of the law of the case alone",
               "state the updated values in the case, and remove `update` or the alternatives");
  if (!issues.empty()) return {};
  return studies_of(given, study, estimated_with, issues);
}

}  // namespace kalfem
