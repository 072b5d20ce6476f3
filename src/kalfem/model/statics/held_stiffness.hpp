// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/linalg/sparse_factor.hpp"
#include "kalfem/model/linear_model.hpp"

namespace kalfem {

/// K with some degrees of freedom prescribed: z = F z_f + prescribed ones, F a selection of columns.
class HeldStiffness {
public:
  /// `stiffness` must outlive it; `held`: ascending positions. Throws NotPositiveDefinite where the free part can move
  /// without force.
  HeldStiffness(const SparseMatrix& stiffness, const std::vector<Eigen::Index>& held);

  /// z with K z = f at the free degrees of freedom, refined twice with its own residual. `z`: the prescribed values, 0
  /// elsewhere.
  [[nodiscard]] Eigen::VectorXd solve(const Eigen::VectorXd& forces, Eigen::VectorXd z) const;

private:
  const SparseMatrix& stiffness_;
  SparseMatrix free_;  ///< F
  SparseFactor factor_;
};

}  // namespace kalfem
