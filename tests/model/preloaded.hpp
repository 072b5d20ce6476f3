// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>

#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/linalg/sparse_factor.hpp"
#include "kalfem/model/assembly/assembly.hpp"
#include "kalfem/model/statics/geometric_stiffness.hpp"

namespace kalfem::test {

/// Lowest natural frequencies [Hz] of a model that carries a load case; none where the load is beyond buckling.
inline Eigen::VectorXd preloaded_frequencies(const FiniteElementModel& model, const LoadCase& preload, int count) {
  const SparseMatrix added = preload_stiffness(model, preload);
  const auto assembled = assemble(model);
  const SparseMatrix stiffness = evaluate(assembled.stiffness, assembled.parameters) +
                                 SparseMatrix(assembled.expansion.transpose() * added * assembled.expansion);
  try {
    const SparseFactor positive_definite(stiffness);
  } catch (const NotPositiveDefinite&) {
    return {};
  }
  const auto modes = lowest_modes(stiffness, evaluate(assembled.mass, assembled.parameters), {.count = count});
  return modes.values.cwiseSqrt() / (2.0 * std::numbers::pi);
}

}  // namespace kalfem::test
