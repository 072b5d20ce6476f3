// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace kalfem {

/// Real basis of invariant subspaces, A V = V diag(B_1, B_2, ...).
struct InvariantSubspaces {
  Eigen::MatrixXd basis;             ///< V, n x n
  Eigen::MatrixXd blocks;            ///< diag(B_1, B_2, ...), n x n
  std::vector<Eigen::Index> starts;  ///< first column of each, then n
};

/// Splits the space into invariant subspaces as small as a well-conditioned basis allows: one column for a real
/// eigenvalue, two for a complex pair, more where eigenvalues lie so close together that splitting them would magnify
/// errors by more than `magnification`. Real Schur form, then from its top each block is decoupled from the rest by a
/// Sylvester equation; where its solution is too large, the nearest eigenvalue of the rest joins the block. Bavely and
/// Stewart, SIAM J. Numer. Anal. 16 (1979) 359-367. A: n x n, finite. Throws InvalidInput where A is not finite or the
/// Schur form does not converge.
InvariantSubspaces invariant_subspaces(const Eigen::MatrixXd& A, double magnification = 1e4);

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
