// SPDX-License-Identifier: Apache-2.0
#include "kalfem/diagnosis/correction.hpp"

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/diagnosis/trial.hpp"
#include "kalfem/identification/likelihood_unknowns.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

FilterRun DiagnosisInput::run() const {
  IssueList issues;
  const auto setup = make_augmented_model_setup(*problem, parts, {}, issues);
  issues.raise();
  FilterRun run = make_filter_run(problem, setup, record);
  for (const auto& change : on_run) change(run);
  return run;
}

DiagnosisInput found_again(const DiagnosisInput& input, const Undo& undo) {
  if (!input.uncorrected) return undo(input).input;
  const auto given = std::make_shared<UncorrectedRun>(*input.uncorrected);
  given->undone.push_back(undo);
  const auto undone_at = [&](const CorrectedProblem& values) {
    auto problem = std::make_shared<EstimationProblem>(*values.problem);
    problem->settings.substeps = input.problem->settings.substeps;
    DiagnosisInput at{.problem = std::move(problem),
                      .parts = given->parts,
                      .record = without(values.record, given->events),
                      .options = input.options,
                      .nis = input.nis,
                      .steps = input.steps,
                      .updated = input.updated};
    for (const auto& each : given->undone) at = each(at).input;
    at.uncorrected = given;
    return at;
  };
  const auto run = [&](const CorrectedProblem& values) {
    const FilterRun made = undone_at(values).run();
    return estimate(*made.choice.augmented_model, made.input,
                    {.filter = made.choice.filter,
                     .unscented = input.options.unscented,
                     .state_deviations = false,
                     .adaptive_noise = input.options.adaptive_noise});
  };
  IssueList issues;
  const auto setup = make_augmented_model_setup(*given->problem, given->parts, {}, issues);
  issues.raise();
  const Record part = first_samples(given->record, input.record.samples());
  if (const auto found = estimate_likelihood_unknowns(given->problem, setup, part, input.options, run))
    return undone_at(found->corrected);
  DiagnosisInput as_found = undo(input).input;
  as_found.uncorrected = given;
  return as_found;
}

Correction about(DiagnosisInput input, StructureModel structure) {
  auto changed = std::make_shared<EstimationProblem>(*input.problem);
  changed->structure = std::make_shared<const StructureModel>(std::move(structure));
  if (!input.of_elements.empty()) {
    std::vector<StructureBinding> bindings;
    VectorXd values(static_cast<Index>(input.of_elements.size()));
    for (const auto& [parameter, value] : input.of_elements) {
      values[static_cast<Index>(bindings.size())] = value;
      bindings.push_back({static_cast<Index>(bindings.size()), parameter});
    }
    input.parts.finite_elements =
        ParameterisedStructure(changed->structure, bindings, values.size()).at(values).parts.finite_elements;
  }
  input.problem = std::move(changed);
  return {std::move(input)};
}

Correction with_forces(const DiagnosisInput& input, const FurtherForces& forces) {
  Correction made{input};
  StructureModel structure = *input.problem->structure;
  for (const auto& connector : forces.connectors) {
    made.input.parts.connectors.push_back(connector);
    made.input.added.push_back(connector.name);
  }
  structure.parts.connectors = made.input.parts.connectors;
  auto changed = std::make_shared<EstimationProblem>(*input.problem);
  changed->structure = std::make_shared<const StructureModel>(std::move(structure));
  for (const auto& unknown : forces.unknowns) changed->settings.unknowns.push_back(unknown);
  made.input.problem = std::move(changed);
  return made;
}

}  // namespace kalfem
