// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/updating_setup.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "kalfem/identification/factor_bounds.hpp"
#include "kalfem/identification/stated_in_updating.hpp"
#include "kalfem/study/estimation_problem_of.hpp"
#include "kalfem/study/known_to_of.hpp"
#include "kalfem/study/spread.hpp"
#include "kalfem/yaml/bounds.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

namespace d = description;

class ParameterBuilder {
public:
  ParameterBuilder(const CaseStudy& study, UpdatingSetup& setup, IssueList& issues)
      : study_(study), known_(*study.structure), setup_(setup), issues_(issues) {}

  void add(const std::string& name, const Located<d::UpdatedParameter>& given) {
    const Name own{name, given.location, given.path};
    const auto names = given.value.applies_to.empty() ? std::vector<Name>{own} : given.value.applies_to;
    std::vector<Parameter> targets;
    for (const auto& each : names)
      if (auto target = resolved(each, name)) targets.push_back(std::move(*target));
    if (targets.size() != names.size()) return;
    try {
      add(name, given.value, targets);
    } catch (const InvalidInput& error) {
      issues_.add(error, own.location);
    }
  }

private:
  std::optional<Parameter> resolved(const Name& target, const std::string& owner) {
    auto parameter = known_.find(target.value);
    if (parameter && parameter->of_connector()) parameter.reset();
    if (!parameter)
      issues_.add(
          target.location,
          target.path + ": there is no parameter '" + target.value + "'" + did_you_mean(target.value, known_.names()),
          "updating changes parameters of linear substructures; parameters of connectors are estimated by the filter "
          "(estimate.unknown)");
    else if (const auto issue = unlike_ratios(study_.given, *parameter, target))
      issues_.add(issue->location, issue->what, issue->why, issue->fix);
    const auto all_ratios = target.value.find(".damping.modal");  // the name without a number means all ratios
    if (all_ratios != std::string::npos) {
      const std::string whole = target.value.substr(0, all_ratios) + ".damping.modal";
      for (const auto& [taken, by] : owners_)
        if (taken != target.value && (taken == whole || (target.value == whole && taken.starts_with(whole + "."))))
          issues_.add(target.location, target.path + ": '" + target.value + "' and '" + taken + "' are both updated",
                      "damping.modal is one value for all ratios", "remove one of them");
    }
    const auto [first, is_new] = owners_.try_emplace(target.value, owner);
    if (!is_new)
      issues_.add(target.location,
                  target.path + ": '" + target.value + "' is updated already by '" + first->second + "'",
                  "a parameter can have only one value", "remove one of them");
    return parameter;
  }

  void add(const std::string& name, const d::UpdatedParameter& given, const std::vector<Parameter>& targets) {
    const std::string unit = targets.front().unit;
    for (const auto& target : targets)
      if (target.unit != unit)
        throw InvalidInput(name + " applies to parameters in " + unit + " and in " + target.unit,
                           "parameters that share a value need the same unit", "list parameters of the same kind");
    UpdatingParameter parameter{name, unit, targets.front().value};
    if (given.initial) parameter.initial = checked_number(*given.initial, unit);
    if (given.std) parameter.deviation = deviation(*given.std, unit, parameter.initial);
    set_bounds(given, unit, parameter);
    std::optional<double> truth;
    if (study_.given.simulate) truth = targets.front().value;
    if (given.truth) truth = checked_number(*given.truth, unit);
    const auto index = static_cast<Index>(setup_.parameters.size());
    for (const auto& target : targets) setup_.bindings.push_back({index, target});
    setup_.parameters.push_back(parameter);
    setup_.true_parameters.push_back(truth);
  }

  double deviation(const d::Value& given, const std::string& unit, double initial) const {
    const double deviation = spread_about(given, unit, initial);
    if (!(deviation > 0.0)) throw InvalidInput(given.issue("the standard deviation of the prior is not positive"));
    return deviation;
  }

  /// The lower bound is 0 unless the case gives bounds: every updated parameter is positive by nature.
  void set_bounds(const d::UpdatedParameter& given, const std::string& unit, UpdatingParameter& parameter) const {
    parameter.lower = 0.0;
    if (!given.bounds) {
      if (!(parameter.initial >= 0.0))
        throw InvalidInput(
            "update.parameters." + parameter.name + ": its initial value is " + shortest(parameter.initial),
            "this parameter must not be negative", "change its initial value");
      return;
    }
    const auto bound = [&](const Quantity& quantity) {
      return checked_number({quantity, given.bounds->location, given.bounds->path}, unit);
    };
    parameter.lower = bound(given.bounds->value[0]);
    parameter.upper = bound(given.bounds->value[1]);
    if (!(parameter.lower < parameter.upper))
      throw InvalidInput("update.parameters." + parameter.name + ": the lower bound is not below the upper one", "",
                         "write bounds: [lower, upper]");
    if (parameter.initial < parameter.lower || parameter.initial > parameter.upper)
      throw InvalidInput("update.parameters." + parameter.name + ": its initial value is " +
                             shortest(parameter.initial) + ", outside its bounds " + shortest(parameter.lower) +
                             " to " + shortest(parameter.upper),
                         "the initial value must lie within the bounds", "change one of them");
  }

  const CaseStudy& study_;
  ParameterSet known_;
  UpdatingSetup& setup_;
  IssueList& issues_;
  std::map<std::string, std::string> owners_;
};

/// An evolution strategy samples between bounds, so every parameter needs two finite ones.
void check_search(const CaseStudy& study, const UpdatingSetup& setup, IssueList& issues) {
  constexpr int fewest_points = 5;
  const auto& given = *study.given.update;
  if (given.method != UpdatingMethod::evolution) return;
  for (const auto& parameter : setup.parameters)
    if (!std::isfinite(parameter.lower) || !std::isfinite(parameter.upper))
      issues.add(study.given.source.at({"update", "parameters", parameter.name}),
                 "update.parameters." + parameter.name + " has no bounds", "method: cma_es needs bounds",
                 "give bounds: [lower, upper]");
  if (given.evolution.population > 0 && given.evolution.population < fewest_points)
    issues.add(study.given.source.at({"update", "evolution", "population"}),
               "update.evolution.population: " + std::to_string(given.evolution.population) + " given",
               "CMA-ES needs at least " + std::to_string(fewest_points) + " points per generation",
               "increase or remove it");
}

/// Gains of what is compared, each once.
std::vector<ComparedGain> gains_of(const CaseStudy& study, const UpdatingPlan& plan) {
  std::vector<ComparedGain> all;
  const auto add = [&](const ComparedGain& gain) {
    if (std::ranges::find(all, gain) == all.end()) all.push_back(gain);
  };
  for (const auto& comparison : plan.comparisons)
    for (const auto& gain : comparison.continuation_steps.back()->gains()) add(gain);
  for (const auto& comparison : plan.record_comparisons)
    if (const auto* simulated = std::get_if<RecordComparison::OfSimulation>(&comparison.what)) {
      for (const auto& sensor : simulated->sensors) add({sensor.name + ".gain", false});
      for (const auto& input : study.structure->parts.inputs) add({input.name + ".gain", true});
    }
  return all;
}

std::set<std::string> names_of_targets(const UpdatingSetup& updating) {
  std::set<std::string> names;
  for (const auto& [index, target] : updating.bindings) names.insert(target.name);
  return names;
}

/// What is stated of numbers that are not updated, and the comparisons as functions of these.
void add_stated(const CaseStudy& study, UpdatingPlan& plan) {
  const d::Updating& given = *study.given.update;
  if (given.known_to.empty()) return;
  const auto updated = names_of_targets(*study.updating);
  const auto held =
      held_in_updating(*study.structure, updated, gains_of(study, plan), !plan.record_comparisons.empty());
  IssueList issues;
  const auto known_to = known_to_of(given.known_to, held, issues);
  check_known_to(known_to, held, updated, issues);
  issues.raise();
  plan.known_to = known_to;
  plan.stated = stated_numbers(held, known_to);
  CaseStudy wide = study;
  wide.updating = with_numbers(*study.updating, plan.stated);
  UpdatingPlan over_all;
  over_all.structure = std::make_shared<const ParameterisedStructure>(study.structure, wide.updating->bindings,
                                                                      std::ssize(wide.updating->parameters));
  std::vector<std::string> told_before;
  add_comparisons(wide, over_all, told_before);
  for (auto& comparison : over_all.record_comparisons)
    if (auto* simulated = std::get_if<RecordComparison::OfSimulation>(&comparison.what))
      simulated->options.connectors = connectors_of(wide.updating->bindings);
  plan.wide = std::make_shared<const WideUpdating>(WideUpdating{*wide.updating, std::move(over_all)});
}

/// Evidence compares what priors predict, so every parameter needs one.
void require_priors(const UpdatingSetup& setup, const std::string& path, const SourceLocation& location,
                    IssueList& issues) {
  for (const auto& parameter : setup.parameters)
    if (!std::isfinite(parameter.deviation))
      issues.add(location, path + "." + parameter.name + ": it has no prior",
                 "alternatives are weighted by their evidence, which depends on the priors' widths", "give `std`");
}

void add_alternatives(const CaseStudy& study, UpdatingPlan& plan) {
  const d::Updating& given = *study.given.update;
  if (given.alternatives.empty()) return;
  IssueList issues;
  require_priors(*study.updating, "update.parameters", plan.location, issues);
  for (const auto& [name, alternative] : given.alternatives) {
    CaseStudy other = study;
    other.given.update->parameters = alternative.value.parameters;
    other.given.update->alternatives.clear();
    try {
      IssueList of_parameters;
      other.updating = make_updating_setup(other, of_parameters);
      of_parameters.raise();
      require_priors(*other.updating, alternative.path + ".parameters", alternative.location, issues);
      std::vector<std::string> told_before;
      plan.alternatives.push_back(std::make_shared<const AlternativeUpdating>(
          AlternativeUpdating{name, *other.updating, make_updating_plan(other, told_before)}));
    } catch (const InvalidInput& error) {
      issues.add(error, alternative.location);
    }
  }
  issues.raise();
}

}  // namespace

UpdatingSetup make_updating_setup(const CaseStudy& study, IssueList& issues) {
  UpdatingSetup setup;
  ParameterBuilder builder(study, setup, issues);
  for (const auto& [name, given] : study.given.update->parameters) builder.add(name, given);
  if (study.given.update->parameters.empty())
    issues.add(study.given.source.at({"update", "parameters"}), "update.parameters is empty",
               "there is nothing to update", "list at least one parameter");
  if (study.given.update->comparisons.empty())
    issues.add(study.given.source.at({"update", "compare"}), "update.compare is empty", "updating needs a measurement",
               "give at least one comparison");
  check_comparisons(study, issues);
  check_search(study, setup, issues);
  if (issues.empty())
    for (const auto& [parameter, issue] : indefinite_at_bounds(study.structure, setup))
      issues.add(study.given.source.at({"update", "parameters", parameter}),
                 "update.parameters." + parameter + ": " + issue.what, issue.why, issue.fix);
  return setup;
}

UpdatingPlan make_updating_plan(const CaseStudy& study, std::vector<std::string>& warnings) {
  const d::Updating& given = *study.given.update;
  const auto& [parameters, bindings, truth] = *study.updating;
  UpdatingPlan plan{.method = given.method, .starts = given.starts, .seed = given.seed};
  plan.search.max_evaluations = given.stages;
  plan.search.step_tolerance = given.tolerance;
  plan.search.cost_floor = 1e-6;  // residuals are in units of their standard deviations
  plan.evolution.generations = static_cast<unsigned>(given.evolution.generations);
  plan.evolution.seed = static_cast<unsigned>(given.evolution.seed);
  const double usual = std::max(8.0, 4.0 + std::floor(3.0 * std::log(static_cast<double>(parameters.size()))));
  plan.evolution.population =
      static_cast<unsigned>(given.evolution.population > 0 ? given.evolution.population : usual);
  plan.check_sensitivities = given.check_sensitivities;
  plan.structure =
      std::make_shared<const ParameterisedStructure>(study.structure, bindings, static_cast<Index>(parameters.size()));
  plan.location = study.given.source.at({"update", "parameters"});
  for (const auto& parameter : parameters)
    plan.parameter_locations[parameter.name] = study.given.source.at({"update", "parameters", parameter.name});
  add_comparisons(study, plan, warnings);
  add_stated(study, plan);
  add_alternatives(study, plan);
  return plan;
}

}  // namespace kalfem
