// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/numbers_at.hpp"

#include "kalfem/identification/freed_numbers.hpp"
#include "kalfem/identification/likelihood_unknowns.hpp"
#include "kalfem/identification/measurement_unknowns.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// The name of the sensor or excitation of a gain or clock.
std::string owner_of(const FixedNumber& number) { return number.name.substr(0, number.name.rfind('.')); }

double value_of(const FixedNumber& number, double change) { return number.value + change * number.scale; }

/// Where finite elements follow unknowns of the filter, these numbers go with them; otherwise they are reduced anew.
HeldElements reduce_at(const StructurePtr& structure, const AugmentedModelSetup& setup, HeldElements held,
                       StructureParts& parts) {
  if (held.parameters.empty() || !setup.linear_unknowns.bindings.empty()) return held;
  std::vector<StructureBinding> bindings;
  for (const auto& parameter : held.parameters) bindings.push_back({std::ssize(bindings), parameter});
  const ParameterisedStructure elements(structure, bindings, std::ssize(bindings));
  parts.finite_elements = elements.at(held.values).parts.finite_elements;
  return {};
}

/// Sets the parameters of connectors and lumped substructures in both; those of finite elements are left.
HeldElements set_parameters(const std::vector<FixedNumber>& numbers, const VectorXd& changes, StructureParts& parts,
                            StructureModel& structure) {
  HeldElements held;
  std::vector<double> values;
  for (Index i = 0; i < changes.size(); ++i) {
    const auto& number = numbers[static_cast<std::size_t>(i)];
    if (!number.parameter || changes[i] == 0.0) continue;
    const double value = value_of(number, changes[i]);
    if (set_parameter(parts, *number.parameter, value)) {
      set_parameter(structure.parts, *number.parameter, value);
      continue;
    }
    held.parameters.push_back(*number.parameter);
    values.push_back(value);
  }
  held.values = VectorXd::Map(values.data(), std::ssize(values));
  return held;
}

/// As their gains and delays change them.
void set_excitations(const std::vector<FixedNumber>& numbers, const VectorXd& changes, StructureModel& structure) {
  for (Index i = 0; i < changes.size(); ++i) {
    const auto& number = numbers[static_cast<std::size_t>(i)];
    if (number.parameter || number.of_sensor || changes[i] == 0.0) continue;
    const auto& inputs = structure.parts.inputs;
    const auto input = std::ranges::find(inputs, owner_of(number), &InputDescription::name);
    if (input == inputs.end()) continue;
    auto& signal = structure.signals[static_cast<std::size_t>(input - inputs.begin())];
    signal = number.is_delay() ? delayed(signal, value_of(number, changes[i]))
                               : scaled(signal, value_of(number, changes[i]));
  }
}

/// Takes out of the record what the sensors' gains and clocks change in it.
void correct_record(const std::vector<FixedNumber>& numbers, const VectorXd& changes, ProblemAtNumbers& at) {
  EstimationProblem with = *at.problem;
  with.settings.likelihood_unknowns.clear();
  std::vector<double> values;
  for (Index i = 0; i < changes.size(); ++i) {
    const auto& number = numbers[static_cast<std::size_t>(i)];
    if (!number.of_sensor || changes[i] == 0.0) continue;
    add_measurement_unknown(name_as_unknown(number), {.initial = number.value, .deviation = number.scale}, with);
    values.push_back(value_of(number, changes[i]));
  }
  auto corrected = kalfem::corrected(std::make_shared<EstimationProblem>(std::move(with)), at.setup, at.record,
                                     VectorXd::Map(values.data(), std::ssize(values)));
  at.record = std::move(corrected.record);
  at.log_jacobian = std::move(corrected.log_jacobian);
}

}  // namespace

double pull(const std::vector<FixedNumber>& numbers, const VectorXd& changes, Index but) {
  double sum = 0.0;
  for (Index i = 0; i < changes.size(); ++i) {
    const double deviation = numbers[static_cast<std::size_t>(i)].deviation;
    if (deviation > 0.0 && i != but) sum += 0.5 * changes[i] * changes[i] / (deviation * deviation);
  }
  return sum;
}

ProblemAtNumbers at_numbers(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup, const Record& record,
                            const ChangedNumbers& changed) {
  const auto& [numbers, changes] = changed;
  auto structure = std::make_shared<StructureModel>(*problem->structure);
  StructureParts parts = *setup.parts;
  HeldElements held = set_parameters(numbers, changes, parts, *structure);
  held = reduce_at(problem->structure, setup, std::move(held), parts);
  set_excitations(numbers, changes, *structure);
  auto at = std::make_shared<EstimationProblem>(*problem);
  at->structure = std::move(structure);
  const auto& linear = setup.linear_unknowns;
  IssueList issues;
  AugmentedModelSetup made =
      make_augmented_model_setup(*at, std::move(parts), linear.present, issues,
                                 linear.bindings.empty() ? std::nullopt : std::optional(linear.reduced_at), held);
  issues.raise();
  made.substeps = setup.substeps;
  made.starts_at_rest = setup.starts_at_rest;
  ProblemAtNumbers result{at, std::move(made), record, {}};
  correct_record(numbers, changes, result);
  return result;
}

}  // namespace kalfem
