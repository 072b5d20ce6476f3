// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <vector>

namespace kalfem {

/// y = A u + B v of two sparse matrices in one sweep over their common pattern: both are read once, side by side.
/// Where B has no entries its vector is not read. A pattern with more than a quarter of all entries, as a superelement
/// with modal damping has, is kept as dense matrices: what an entry takes then is a fifth.
class PairedProduct {
public:
  PairedProduct(const Eigen::SparseMatrix<double>& a, const Eigen::SparseMatrix<double>& b);

  /// y is resized at the first use.
  void multiply(const Eigen::VectorXd& u, const Eigen::VectorXd& v, Eigen::VectorXd& y) const;

private:
  [[nodiscard]] bool single() const { return b_.empty(); }
  void sweep(const double* u, const double* v, double* y) const;

  Eigen::Index rows_ = 0;
  std::vector<int> start_, column_;
  std::vector<double> a_, b_;
  Eigen::MatrixXd dense_a_, dense_b_;  ///< in the place of the pattern; empty where it is sparse
};

/// The block of a sparse matrix at the given rows and columns, in their order.
Eigen::SparseMatrix<double> select(const Eigen::SparseMatrix<double>& matrix, const std::vector<Eigen::Index>& rows,
                                   const std::vector<Eigen::Index>& columns);

}  // namespace kalfem
