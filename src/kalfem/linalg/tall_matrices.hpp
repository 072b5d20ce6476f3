// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <Eigen/Sparse>

namespace kalfem {

// Products with matrices of as many rows as a large model has degrees of freedom and some columns each. They work by
// panels, so that nothing else has the size of these matrices.

using TallMatrix = Eigen::Ref<const Eigen::MatrixXd>;  ///< whose columns are contiguous

/// Y = A X of a symmetric sparse A, n x n. Each entry of A is read once for eight columns of X, which lie side by side
/// in memory meanwhile: where A is larger than the processor's caches, this takes a third of the time. One thread at a
/// time.
class SymmetricProduct {
public:
  /// `matrix`, of which both halves are stored, is kept by reference.
  explicit SymmetricProduct(const Eigen::SparseMatrix<double>& matrix);

  /// `product` may be `columns` itself.
  void multiply(const TallMatrix& columns, Eigen::Ref<Eigen::MatrixXd> product);

private:
  static constexpr Eigen::Index width = 8;

  const Eigen::SparseMatrix<double>& matrix_;
  Eigen::Matrix<double, Eigen::Dynamic, width, Eigen::RowMajor> side_by_side_;
};

/// Columns that are worked on at once: in back-solves wider panels need as much memory again, and save no more than a
/// tenth.
constexpr Eigen::Index widest_panel = 32;

/// Calls work(first, count) for panels of about equally many columns, at most `widest`.
template <class Work>
void by_panels(Eigen::Index columns, Eigen::Index widest, const Work& work) {
  const Eigen::Index panels = (columns + widest - 1) / widest;
  for (Eigen::Index panel = 0; panel < panels; ++panel) {
    const Eigen::Index first = columns * panel / panels;
    work(first, columns * (panel + 1) / panels - first);
  }
}

/// X W in place of the leading columns of X, for a W with no more columns than rows.
void combine(Eigen::Ref<Eigen::MatrixXd> X, const TallMatrix& W);

}  // namespace kalfem
