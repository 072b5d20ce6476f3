#include "kalfem/casefile/modifications.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kalfem/casefile/bounds.hpp"
#include "kalfem/casefile/parameterised_structure.hpp"
#include "kalfem/linalg/lowest_modes.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

namespace d = description;

/// What the updating refined with its values, and behind it what the modification sets.
struct Changes {
  std::vector<StructureBinding> bindings;
  std::vector<double> values;

  void set(const StructureParameter& parameter, double value) {
    bindings.push_back({static_cast<Index>(values.size()), parameter});
    values.push_back(value);
  }
};

double value_in_unit(const d::Value& given, const StructureParameter& parameter) {
  return checked_number(given, parameter.unit, Bounds::nonnegative());
}

Changes changes_of(const Study& study, const d::Modification& given, const std::optional<UpdatingStage>& updating) {
  Changes changes;
  if (updating) {
    changes.bindings = study.updating->bindings;
    changes.values.assign(updating->values.begin(), updating->values.end());
  }
  for (const auto& [name, value] : given.set) {
    const auto parameter = find_structure_parameter(study, given.substructure.value + "." + name);
    changes.set(*parameter, value_in_unit(value, *parameter));
  }
  return changes;
}

Index dofs_with_mass(const LinearModel& model) { return (model.mass.diagonal().array() > 0.0).count(); }

/// The lowest natural frequencies above a limit [Hz].
VectorXd frequencies_above(const LinearModel& model, double limit, Index wanted) {
  const Index most = dofs_with_mass(model);
  for (Index count = std::min(most, wanted + 10);; count = std::min(most, 2 * count)) {
    const VectorXd values = lowest_modes(model.stiffness, model.mass, {.count = count}).values;
    const VectorXd frequencies = values.cwiseMax(0.0).cwiseSqrt() / (2.0 * std::numbers::pi);
    const Index skipped = (frequencies.array() <= limit).count(), found = frequencies.size() - skipped;
    if (found >= wanted || count == most) return frequencies.segment(skipped, std::min(found, wanted));
  }
}

}  // namespace

std::vector<ModificationResult> predict_modifications(const Study& study,
                                                      const std::optional<UpdatingStage>& updating) {
  std::vector<ModificationResult> results;
  for (const auto& [name, located] : study.given.modifications) {
    const auto& given = located.value;
    const Changes changes = changes_of(study, given, updating);
    const VectorXd values =
        Eigen::Map<const VectorXd>(changes.values.data(), static_cast<Index>(changes.values.size()));
    const ParameterisedStructure structure(study, changes.bindings, values.size());
    try {
      const auto model = structure.model_of(given.substructure.value)->at(values).model;
      results.push_back({name, given.substructure.value, frequencies_above(model, given.above, given.modes)});
    } catch (const InvalidInput& error) {
      IssueList issues;
      for (const auto& issue : error.issues())
        issues.add(located.location, located.path + ": " + issue.what, issue.why, issue.fix);
      issues.raise();
    }
    if (results.back().frequencies.size() == 0)
      throw InvalidInput(
          located.issue("no natural frequency lies above " + shortest(given.above) + " Hz", "", "lower `above`"));
  }
  return results;
}

void check_modifications(const Study& study, IssueList& issues) {
  std::vector<std::string> parts;
  for (const auto& [name, part] : study.given.substructures) parts.push_back(name);
  for (const auto& [name, located] : study.given.modifications) {
    const auto& given = located.value;
    const auto& part = given.substructure;
    if (std::ranges::find(parts, part.value) == parts.end()) {
      issues.add(part.location,
                 part.path + ": there is no substructure '" + part.value + "'" + did_you_mean(part.value, parts));
      continue;
    }
    for (const auto& [target, value] : given.set) {
      const std::string full = part.value + "." + target;
      const auto parameter = find_structure_parameter(study, full);
      if (!parameter) {
        issues.add(value.location, value.path + ": there is no parameter '" + full + "'" +
                                       did_you_mean(full, structure_parameter_names(study)));
        continue;
      }
      try {
        value_in_unit(value, *parameter);
      } catch (const InvalidInput& error) {
        issues.add(error, value.location);
      }
    }
  }
}

}  // namespace kalfem
