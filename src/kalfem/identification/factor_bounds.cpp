// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/factor_bounds.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/base/units.hpp"
#include "kalfem/identification/parameterised_structure.hpp"
#include "kalfem/linalg/sparse_factor.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// A negative eigenvalue below these parts of the diagonal is rounding: of a structure, and of a part alone, whose
/// matrix may have been written with few digits.
constexpr double rounding_of_structure = 1e-9, rounding_of_part = 1e-6;

/// Whether A + rounding diag(A) can be factored. Rows of zeros are those of motions that the matrix does not touch.
bool is_semidefinite(const SparseMatrix& matrix, double rounding) {
  if (matrix.nonZeros() == 0) return true;
  const VectorXd diagonal = matrix.diagonal();
  if (diagonal.minCoeff() < 0.0) return false;
  const double mean = diagonal.mean();
  if (mean == 0.0) return false;
  const VectorXd springs = diagonal.unaryExpr([&](double entry) { return rounding * (entry > 0.0 ? entry : mean); });
  try {
    SparseFactor(matrix, {}, springs);
    return true;
  } catch (const NotPositiveDefinite&) {
    return false;
  }
}

/// The factor of a part behind a binding; null for other parameters.
const PartFactor* factor_of(const StructureModel& structure, const Parameter& parameter) {
  const auto* target = std::get_if<FiniteElementParameter>(&parameter.where);
  if (!target || target->kind != FiniteElementParameter::Kind::matrix) return nullptr;
  for (const auto& each : structure.finite_elements)
    if (each.part->name == parameter.owner)
      for (const auto& factor : each.part->elements.factors)
        if (factor.name + ".factor" == target->name) return &factor;
  return nullptr;
}

/// What is indefinite, in words; empty: nothing.
std::string indefinite(const SparseMatrix& stiffness, const SparseMatrix& mass, double rounding) {
  if (!is_semidefinite(stiffness, rounding)) return "stiffness";
  return is_semidefinite(mass, rounding) ? "" : "mass";
}

}  // namespace

std::vector<std::pair<std::string, Issue>> indefinite_at_bounds(const StructurePtr& structure,
                                                                const UpdatingSetup& setup) {
  std::vector<std::pair<std::string, Issue>> found;
  const auto count = std::ssize(setup.parameters);
  const ParameterisedStructure parameterised(structure, setup.bindings, count);
  const VectorXd start = initial_values(setup.parameters);
  for (const auto& [index, target] : setup.bindings) {
    const auto& parameter = setup.parameters[static_cast<std::size_t>(index)];
    const PartFactor* factor = factor_of(*structure, target);
    if (!factor || (!factor->cells.empty() && parameter.lower >= 0.0)) continue;
    const auto model = parameterised.model_of(target.owner);
    const auto add = [&](const std::string& what, const std::string& fix) {
      found.push_back({parameter.name, {{}, what, "the matrices of a structure have no negative eigenvalue", fix}});
    };
    for (const double bound : {parameter.lower, parameter.upper}) {
      if (!std::isfinite(bound)) continue;
      VectorXd values = start;
      values[index] = bound;
      const LinearModel at = model->at(values).model;
      if (const auto which = indefinite(at.stiffness, at.mass, rounding_of_structure); !which.empty())
        add("at its bound " + shortest(bound) + " the " + which + " of '" + target.owner + "' is indefinite",
            "give narrower bounds, or correct the factor's matrix");
    }
    if (std::isfinite(parameter.upper)) continue;
    const auto slope = model->derivatives(start)[static_cast<std::size_t>(index)];
    if (const auto which = indefinite(slope.stiffness, slope.mass, rounding_of_part); !which.empty())
      add("it has no upper bound, and the " + which + " matrix that it multiplies has negative eigenvalues",
          "give bounds: [lower, upper]");
  }
  return found;
}

}  // namespace kalfem
