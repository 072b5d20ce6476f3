// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/structural_modifications.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "kalfem/base/units.hpp"
#include "kalfem/identification/parameterised_structure.hpp"
#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/statistics/mixture.hpp"
#include "kalfem/study/case_study.hpp"
#include "kalfem/updating/eigen_sensitivities.hpp"
#include "kalfem/yaml/bounds.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// The updated parameters with their values, the stated numbers of the structure, then the parameters that the
/// modification sets.
struct Changes {
  std::vector<StructureBinding> bindings;
  std::vector<double> values;

  void set(const Parameter& parameter, double value) {
    bindings.push_back({static_cast<Index>(values.size()), parameter});
    values.push_back(value);
  }
};

Changes changes_of(const Study& study, const StructuralModification& modification,
                   const std::optional<UpdatedParameters>& updating) {
  Changes changes;
  if (updating) {
    const bool considers = updating->considered.has_value();
    changes.bindings = (considers ? study.updating_plan->wide->setup : *study.updating).bindings;
    changes.values.assign(updating->values.begin(), updating->values.end());
    for (const auto& number : study.updating_plan->stated)
      if (considers && number.parameter) changes.values.push_back(number.value);
  }
  for (const auto& [parameter, value] : modification.set) {
    // A value that the modification sets replaces the updated one.
    std::erase_if(changes.bindings, [&](const auto& binding) { return binding.target.name == parameter.name; });
    changes.set(parameter, value);
  }
  return changes;
}

Index dofs_with_mass(const LinearModel& model) { return (model.mass.diagonal().array() > 0.0).count(); }

double frequency_of(double lambda) { return std::sqrt(std::max(lambda, 0.0)) / (2.0 * std::numbers::pi); }

/// Modes `first` to `first + count` of the computed ones.
struct ModeRange {
  LowestModes modes;
  Index first = 0, count = 0;

  [[nodiscard]] VectorXd frequencies() const { return modes.values.segment(first, count).unaryExpr(&frequency_of); }
};

/// The lowest modes with frequencies above a limit [Hz]. The number of modes below it is unknown, so the computation is
/// repeated with twice as many until enough lie above.
ModeRange modes_above(const LinearModel& model, double limit, Index wanted) {
  const Index most = dofs_with_mass(model);
  for (Index count = std::min(most, wanted + 10);; count = std::min(most, 2 * count)) {
    auto modes = lowest_modes(model.stiffness, model.mass, {.count = count});
    const Index skipped = (modes.values.unaryExpr(&frequency_of).array() <= limit).count();
    const Index found = modes.values.size() - skipped;
    if (found >= wanted || count == most) return {std::move(modes), skipped, std::min(found, wanted)};
  }
}

/// Derivatives of the frequencies [Hz per unit], modes x parameters. Rigid-body modes have none.
MatrixXd frequency_derivatives(const ModeRange& range, const std::vector<ModelDerivative>& derivatives) {
  const VectorXd frequencies = range.frequencies();
  MatrixXd slopes = MatrixXd::Zero(range.count, static_cast<Index>(derivatives.size()));
  for (Index p = 0; p < slopes.cols(); ++p) {
    const auto& derivative = derivatives[static_cast<std::size_t>(p)];
    if (derivative.stiffness.nonZeros() == 0 && derivative.mass.nonZeros() == 0) continue;
    for (Index j = 0; j < range.count; ++j) {
      if (frequencies[j] <= 0.0) continue;
      const double slope = projected_derivative(range.modes, {range.first + j, 1}, derivative)(0, 0);
      slopes(j, p) = slope / (8.0 * std::numbers::pi * std::numbers::pi * frequencies[j]);
    }
  }
  return slopes;
}

/// sqrt(g^T S g) for each row g. A parameter without a finite deviation counts only where the row depends on it; one at
/// its bound counts as known.
VectorXd propagated_deviations(const MatrixXd& slopes, const ParameterStatistics& statistics) {
  const MatrixXd covariance = statistics.covariance.unaryExpr([](double c) { return std::isfinite(c) ? c : 0.0; });
  VectorXd deviations(slopes.rows());
  for (Index j = 0; j < slopes.rows(); ++j) {
    VectorXd known = slopes.row(j);
    bool unknown = false;
    for (Index p = 0; p < known.size(); ++p) {
      if (std::isfinite(statistics.deviations[p]) || statistics.at_bound[static_cast<std::size_t>(p)]) continue;
      unknown = unknown || known[p] != 0.0;
      known[p] = 0.0;
    }
    const double variance = known.dot(covariance * known);
    deviations[j] = unknown ? std::numeric_limits<double>::infinity() : std::sqrt(std::max(variance, 0.0));
  }
  return deviations;
}

/// What stated numbers add, the updated parameters following them. `slopes`: of the parameters, then of the numbers of
/// the structure.
VectorXd considered_deviations(const MatrixXd& slopes, const std::vector<FixedNumber>& numbers,
                               const Considered& considered) {
  const Index parameters = considered.shift.rows();
  VectorXd variance = VectorXd::Zero(slopes.rows());
  Index column = parameters;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    VectorXd moved = slopes.leftCols(parameters) * considered.shift.col(static_cast<Index>(i));
    if (numbers[i].parameter) moved += numbers[i].scale * slopes.col(column++);
    variance += (numbers[i].deviation * moved).cwiseAbs2();
  }
  return variance.cwiseSqrt();
}

void set_deviations(const MatrixXd& slopes, const Study& study, const UpdatedParameters& updating,
                    StructuralModificationResult& result) {
  result.deviations = propagated_deviations(slopes.leftCols(updating.values.size()), updating.statistics);
  if (!updating.considered) return;
  result.considered = considered_deviations(slopes, study.updating_plan->stated, *updating.considered);
  result.deviations = (result.deviations.cwiseAbs2() + result.considered.cwiseAbs2()).cwiseSqrt();
}

}  // namespace

StructuralModificationResult mixed(const std::vector<StructuralModificationResult>& models, const VectorXd& weights) {
  Index modes = models.front().frequencies.size();
  for (const auto& each : models) modes = std::min(modes, each.frequencies.size());
  std::vector<VectorXd> frequencies, deviations;
  for (const auto& each : models) {
    frequencies.push_back(each.frequencies.head(modes));
    deviations.push_back(each.deviations.head(modes));
  }
  std::vector<MixedModel> parts;
  for (std::size_t m = 0; m < models.size(); ++m)
    parts.push_back({weights[static_cast<Index>(m)], frequencies[m], deviations[m]});
  const auto [mean, deviation] = mixture_of(parts);
  return {models.front().name, models.front().substructure, mean, deviation, {}};
}

std::vector<StructuralModification> make_modifications(const CaseStudy& study, IssueList& issues) {
  const ParameterSet known(*study.structure);
  std::vector<std::string> parts;
  for (const auto& [name, part] : study.given.substructures) parts.push_back(name);
  std::vector<StructuralModification> all;
  for (const auto& [name, located] : study.given.modifications) {
    const auto& given = located.value;
    const auto& part = given.substructure;
    if (std::ranges::find(parts, part.value) == parts.end()) {
      issues.add(part.location,
                 part.path + ": there is no substructure '" + part.value + "'" + did_you_mean(part.value, parts));
      continue;
    }
    StructuralModification modification{
        {name, located.location, located.path}, part.value, {}, given.modes, given.above};
    for (const auto& [target, value] : given.set) {
      const std::string full = part.value + "." + target;
      const auto parameter = known.find(full);
      if (!parameter) {
        issues.add(value.location,
                   value.path + ": there is no parameter '" + full + "'" + did_you_mean(full, known.names()));
        continue;
      }
      try {
        modification.set.emplace_back(*parameter, checked_number(value, parameter->unit, Bounds::nonnegative()));
      } catch (const InvalidInput& error) {
        issues.add(error, value.location);
      }
    }
    all.push_back(std::move(modification));
  }
  return all;
}

std::vector<StructuralModificationResult> predict_modifications(const Study& study,
                                                                const std::optional<UpdatedParameters>& updating) {
  std::vector<StructuralModificationResult> results;
  for (const auto& modification : study.modifications) {
    const Changes changes = changes_of(study, modification, updating);
    const VectorXd values =
        Eigen::Map<const VectorXd>(changes.values.data(), static_cast<Index>(changes.values.size()));
    const ParameterisedStructure structure(study.structure, changes.bindings, values.size());
    try {
      const auto model = structure.model_of(modification.substructure);
      const ModeRange range = modes_above(model->at(values).model, modification.above, modification.modes);
      results.push_back({modification.name.value, modification.substructure, range.frequencies(), {}, {}});
      if (updating) {
        const MatrixXd slopes = frequency_derivatives(range, model->derivatives(values));
        set_deviations(slopes, study, *updating, results.back());
      }
    } catch (const InvalidInput& error) {
      IssueList issues;
      for (const auto& issue : error.issues())
        issues.add(modification.name.location, modification.name.path + ": " + issue.what, issue.why, issue.fix);
      issues.raise();
    }
    if (results.back().frequencies.size() == 0)
      throw InvalidInput(modification.name.issue(
          "no natural frequency lies above " + shortest(modification.above) + " Hz", "", "lower `above`"));
  }
  return results;
}

}  // namespace kalfem
