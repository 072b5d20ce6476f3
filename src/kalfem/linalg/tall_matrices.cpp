// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/tall_matrices.hpp"

#include <algorithm>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Matrix = Eigen::SparseMatrix<double>;

SymmetricProduct::SymmetricProduct(const Matrix& matrix) : matrix_(matrix), side_by_side_(matrix.rows(), width) {
  side_by_side_.setZero();
}

// Row i of A is its column i, so that row i of the product is a sum over that column.
void SymmetricProduct::multiply(const TallMatrix& columns, Eigen::Ref<MatrixXd> product) {
  for (Index first = 0; first < columns.cols(); first += width) {
    const Index count = std::min(width, columns.cols() - first);
    side_by_side_.leftCols(count) = columns.middleCols(first, count);
    for (Index i = 0; i < matrix_.cols(); ++i) {
      Eigen::Matrix<double, 1, width> sum = Eigen::Matrix<double, 1, width>::Zero();
      for (Matrix::InnerIterator entry(matrix_, i); entry; ++entry)
        sum.noalias() += entry.value() * side_by_side_.row(entry.row());
      product.row(i).segment(first, count) = sum.head(count);
    }
  }
}

void combine(Eigen::Ref<MatrixXd> X, const TallMatrix& W) {
  constexpr Index panel = 6144;
  MatrixXd combined;
  for (Index first = 0; first < X.rows(); first += panel) {
    auto rows = X.middleRows(first, std::min(panel, X.rows() - first));
    combined.noalias() = rows.leftCols(W.rows()) * W;
    rows.leftCols(W.cols()) = combined;
  }
}

}  // namespace kalfem
