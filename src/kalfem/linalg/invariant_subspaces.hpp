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

}  // namespace kalfem
