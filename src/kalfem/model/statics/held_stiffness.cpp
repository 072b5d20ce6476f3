// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/statics/held_stiffness.hpp"

#include <algorithm>

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// Columns of the identity for all degrees of freedom but the held ones.
SparseMatrix selection(Index size, const std::vector<Index>& held) {
  std::vector<Eigen::Triplet<double>> entries;
  for (Index i = 0; i < size; ++i)
    if (!std::ranges::binary_search(held, i))
      entries.emplace_back(static_cast<int>(i), static_cast<int>(entries.size()), 1.0);
  SparseMatrix matrix(size, static_cast<Index>(entries.size()));
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

}  // namespace

HeldStiffness::HeldStiffness(const SparseMatrix& stiffness, const std::vector<Index>& held)
    : stiffness_(stiffness),
      free_(selection(stiffness.cols(), held)),
      factor_(SparseMatrix(free_.transpose() * stiffness * free_)) {}

// Each turn of the loop solves for what is left of the forces: the first for the solution, the others refine it.
VectorXd HeldStiffness::solve(const VectorXd& forces, VectorXd z) const {
  constexpr int refinements = 2;
  for (int i = 0; i <= refinements; ++i) {
    const VectorXd left = free_.transpose() * (forces - stiffness_ * z);
    z += free_ * VectorXd(factor_.solve(left));
  }
  return z;
}

}  // namespace kalfem
