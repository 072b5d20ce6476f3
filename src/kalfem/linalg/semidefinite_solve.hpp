#pragma once

#include <Eigen/Dense>
#include <Eigen/Sparse>

namespace kalfem {

/// X with K X = B, n x k, for a positive semi-definite K, n x n, and B in its range: K is factored with a shift far
/// below what matters in it, and X refined with K itself, so that motions without strain stay out of X.
Eigen::MatrixXd semidefinite_solve(const Eigen::SparseMatrix<double>& matrix, const Eigen::MatrixXd& right_side);

}  // namespace kalfem
