// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/update.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/api/structure_description.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/diagnosis/judge_updating.hpp"
#include "kalfem/identification/parameterised_structure.hpp"
#include "kalfem/updating/gauss_newton.hpp"
#include "kalfem/updating/modal_residual.hpp"
#include "kalfem/updating/parameter_interval.hpp"
#include "kalfem/updating/parameter_statistics.hpp"
#include "kalfem/updating/robust_statistics.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// The updated parameters, looked up.
struct Refined {
  std::vector<UpdatingParameter> parameters;
  std::vector<StructureBinding> bindings;
};

/// Throws InvalidInput if it cannot be updated.
Parameter parameter_of(const RefinedParameter& given, const ParameterSet& all, const std::string& substructure) {
  auto parameter = all.find(given.name);
  if (!parameter)
    throw InvalidInput("there is no parameter '" + given.name + "'" + did_you_mean(given.name, all.names()),
                       "it must be a number of the substructure", "Structure::parameters() lists them");
  if (parameter->of_connector() || parameter->owner != substructure)
    throw InvalidInput("the modes of '" + substructure + "' do not depend on it",
                       "only numbers of the substructure that was measured are refined", "remove it");
  return *parameter;
}

UpdatingParameter start_of(const RefinedParameter& given, const Parameter& parameter) {
  UpdatingParameter start{given.name, parameter.unit, given.range.initial.value_or(parameter.value), given.range.lower,
                          given.range.upper};
  if (given.range.std) start.deviation = *given.range.std;
  require_startable({start});
  return start;
}

Refined refined(const StructureModel& structure, const UpdateOptions& options) {
  const ParameterSet all(structure);
  Refined made;
  IssueList issues;
  for (std::size_t i = 0; i < options.parameters.size(); ++i) try {
      const auto& given = options.parameters[i];
      const Parameter parameter = parameter_of(given, all, options.substructure);
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

std::vector<MeasuredMode> measured_modes(const std::vector<MeasuredFrequency>& given) {
  std::vector<MeasuredMode> modes;
  IssueList issues;
  for (std::size_t i = 0; i < given.size(); ++i) {
    const auto& [frequency, std, mode] = given[i];
    if (!(frequency > 0.0) || !(std > 0.0))
      issues.add({},
                 "frequencies[" + std::to_string(i) + "]: " + shortest(frequency) +
                     " Hz with a standard deviation of " + shortest(std) + " Hz",
                 "both must be > 0", "");
    modes.push_back({.frequency = frequency, .deviation = std, .model_mode = mode});
  }
  if (given.empty()) issues.add({}, "frequencies: the list is empty", "there is nothing to compare with", "");
  issues.raise();
  return modes;
}

std::vector<std::string> names_of_parameters(const UpdateOptions& options) {
  std::vector<std::string> names;
  for (const auto& parameter : options.parameters) names.push_back(parameter.name);
  return names;
}

/// Both kinds of deviations at the end of a search, and what they say with the residual about the numbers.
void judge(const ModalResidual& residual, const std::vector<UpdatingParameter>& parameters,
           const LeastSquaresOutcome& outcome, const std::vector<PairedMode>& pairs, UpdateResult& result) {
  const auto& value = outcome.residual;
  if (value.jacobian.size() == 0) {
    result.verdict.add({"failed", "", "the updating has no deviations: " + outcome.reason(),
                        "change the initial values or the bounds", VerdictState::unusable, unusable_widening});
    return;
  }
  const std::string name = "frequencies";
  const auto statistics = parameter_statistics(parameters, outcome.parameters, value);
  const auto robust = robust_statistics(parameters, value, {{name, 0, residual.size(), residual.layout()}}, statistics);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const auto at = static_cast<Index>(i);
    result.parameters[i].std = statistics.deviations[at];
    result.parameters[i].std_robust = robust.deviations[at];
    if (const auto interval = parameter_interval(parameters[i], at, outcome.parameters[at], statistics, robust))
      result.parameters[i].interval_95 = {interval->lower, interval->upper};
  }
  const double size = static_cast<double>(residual.size());
  result.verdict.add(updating_reasons(
      {.parameters = parameters,
       .values = outcome.parameters,
       .statistics = statistics,
       .robust = robust,
       .comparisons = {{name, residual.size(), std::sqrt(value.values.squaredNorm() / size), false, pairs}},
       .converged = outcome.usable(),
       .termination = outcome.reason()}));
}

}  // namespace

UpdateResult update(const Structure& structure, const UpdateOptions& options) {
  const auto model = make_structure_model(structure.description(), {.parameters = names_of_parameters(options)});
  const auto [parameters, bindings] = refined(*model, options);
  const auto substructure =
      ParameterisedStructure(model, bindings, std::ssize(parameters)).model_of(options.substructure);
  if (!substructure)
    throw InvalidInput("substructure '" + options.substructure + "': there is none of that name", "", "");
  const VectorXd start = initial_values(parameters);
  const ModalResidual residual(substructure, measured_modes(options.frequencies), {}, start, {.above = options.above});
  const auto outcome =
      minimise(residual, parameters, {.search = {.max_evaluations = options.max_evaluations, .cost_floor = 1e-6}});

  UpdateResult result{.converged = outcome.usable(), .reason = outcome.reason()};
  const auto before = residual.compare(start).pairs, after = residual.compare(outcome.parameters).pairs;
  for (std::size_t i = 0; i < before.size(); ++i)
    result.frequencies.push_back({before[i].measured_frequency, before[i].model_frequency, after[i].model_frequency});
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const auto at = static_cast<Index>(i);
    result.parameters.push_back({.name = parameters[i].name,
                                 .unit = parameters[i].unit,
                                 .initial = start[at],
                                 .value = outcome.parameters[at],
                                 .std = std::numeric_limits<double>::infinity()});
  }
  judge(residual, parameters, outcome, after, result);
  return result;
}

}  // namespace kalfem
