#pragma once

#include <Eigen/Dense>
#include <vector>

namespace kalfem {

/// A = T B T^-1 with B real and block diagonal; a pair of complex eigenvalues is a block of two.
struct BlockDiagonalForm {
  Eigen::MatrixXd basis;             ///< T, n x n
  Eigen::MatrixXd inverse;           ///< T^-1, n x n
  Eigen::MatrixXd blocks;            ///< B, n x n, exact zeros outside its blocks
  std::vector<Eigen::Index> starts;  ///< first row of each block, then n

  [[nodiscard]] Eigen::Index largest_block() const;
};

/// Finds it for matrices as dynamics have them: several parts of which some act on others only one way (a structure on
/// its sensors' filters, input models on the structure). The pattern of A's zeros gives the irreducible parts; groups
/// of one or two states stay as they are (a rigid-body mode [0 1; 0 0] among them), larger ones are split into
/// invariant subspaces; then parts that act on others are decoupled by Sylvester equations,
///     A_ii X_ij - X_ij A_jj = -(sum of A_ik X_kj, j <= k < i).
/// Parts whose eigenvalues meet cannot be decoupled and are taken together. Identical filters behind several sensors
/// are no difficulty, since they do not act on each other. A: n x n, finite; throws InvalidInput where it is not.
BlockDiagonalForm block_diagonal_form(const Eigen::MatrixXd& A);

}  // namespace kalfem
