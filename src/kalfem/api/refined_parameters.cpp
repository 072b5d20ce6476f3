// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/refined_parameters.hpp"

#include <algorithm>

#include "kalfem/identification/factor_bounds.hpp"
#include "kalfem/updating/gauss_newton.hpp"
#include "kalfem/updating/parameter_statistics.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

/// Throws InvalidInput if it cannot be updated.
Parameter parameter_of(const RefinedParameter& given, const ParameterSet& all, const UpdateOptions& options) {
  auto parameter = all.find(given.name);
  if (!parameter)
    throw InvalidInput("there is no parameter '" + given.name + "'" + did_you_mean(given.name, all.names()),
                       "it must be a number of the substructure", "Structure::parameters() lists them");
  if (options.comparisons.empty() && (parameter->of_connector() || parameter->owner != options.substructure))
    throw InvalidInput("the modes of '" + options.substructure + "' do not depend on it",
                       "only numbers of the substructure that was measured are refined", "remove it");
  if (parameter->of_connector())
    throw InvalidInput("it is a number of a connector", "updating refines numbers of linear substructures",
                       "estimate() finds those of connectors");
  return *parameter;
}

UpdatingParameter start_of(const RefinedParameter& given, const Parameter& parameter) {
  UpdatingParameter start{given.name, parameter.unit, given.range.initial.value_or(parameter.value), given.range.lower,
                          given.range.upper};
  if (given.range.std) start.deviation = *given.range.std;
  require_startable({start});
  return start;
}

}  // namespace

Refined refined(const StructureModel& structure, const UpdateOptions& options) {
  const ParameterSet all(structure);
  Refined made;
  IssueList issues;
  for (std::size_t i = 0; i < options.parameters.size(); ++i) try {
      const auto& given = options.parameters[i];
      const Parameter parameter = parameter_of(given, all, options);
      made.parameters.push_back(start_of(given, parameter));
      made.bindings.push_back({static_cast<Index>(i), parameter});
    } catch (const InvalidInput& error) {
      for (const auto& issue : error.issues())
        issues.add({}, "parameters[" + std::to_string(i) + "] '" + options.parameters[i].name + "': " + issue.what,
                   issue.why, issue.fix);
    }
  if (options.parameters.empty()) issues.add({}, "parameters: the list is empty", "there is nothing to refine", "");
  issues.raise();
  return made;
}

void require_definite(const StructurePtr& structure, const Refined& refined) {
  IssueList issues;
  for (const auto& [name, issue] : indefinite_at_bounds(structure, {refined.parameters, refined.bindings, {}}))
    issues.add({}, "parameters: '" + name + "': " + issue.what, issue.why, issue.fix);
  issues.raise();
}

std::vector<std::string> names_of_parameters(const UpdateOptions& options) {
  std::vector<std::string> names;
  for (const auto& parameter : options.parameters) names.push_back(parameter.name);
  return names;
}

ResidualSum sum_of(const std::vector<MadeComparison>& comparisons, std::size_t step) {
  std::vector<ResidualSum::Term> terms;
  for (const auto& each : comparisons)
    terms.push_back({each.continuation[std::min(step, each.continuation.size() - 1)], each.weight});
  return ResidualSum(std::move(terms));
}

ResidualValue first_values(const ResidualSum& residual, const std::vector<UpdatingParameter>& parameters) {
  const auto first = residual.evaluate(initial_values(parameters), true);
  if (!first)
    throw InvalidInput("parameters: the model has no response at the initial values",
                       "the updating starts from these values", "change the initial values");
  IssueList issues;
  for (const auto& name : without_effect(parameters, first->jacobian))
    issues.add({}, "parameters: no comparison depends on '" + name + "'",
               "a measurement must depend on a parameter to identify it",
               "remove it, or compare with a measurement that depends on it");
  issues.raise();
  return *first;
}

}  // namespace kalfem
