// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <Eigen/Sparse>

namespace kalfem::test {

/// Positive definite, with entries beside the diagonal and far from it.
inline Eigen::SparseMatrix<double> symmetric_matrix(Eigen::Index n) {
  Eigen::MatrixXd dense = 9.0 * Eigen::MatrixXd::Identity(n, n);
  for (Eigen::Index i = 0; i + 1 < n; ++i) dense(i, i + 1) = dense(i + 1, i) = 1.0 / double(i + 1);
  for (Eigen::Index i = 0; i < n / 2; ++i) dense(i, n - 1 - i) = dense(n - 1 - i, i) = -2.0;
  return dense.sparseView();
}

}  // namespace kalfem::test
