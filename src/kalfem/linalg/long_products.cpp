// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/long_products.hpp"

#include <algorithm>

#include "kalfem/linalg/tall_matrices.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Matrix = Eigen::SparseMatrix<double>;

void visit_products(
    const Matrix& A, const LongVectors& X, Index count,
    const std::function<void(Index first, Eigen::Ref<MatrixXd> panel, const TallMatrix& product)>& visit) {
  if (A.nonZeros() == 0) return;
  SymmetricProduct product(A);
  MatrixXd panels(X.rows(), std::min(widest_panel, count)), images(panels.rows(), panels.cols());
  by_panels(count, widest_panel, [&](Index first, Index width) {
    auto panel = panels.leftCols(width), image = images.leftCols(width);
    X.get(first, panel);
    product.multiply(panel, image);
    visit(first, panel, image);
  });
}

MatrixXd gram(const LongVectors& X, const Matrix& A, Index count) {
  MatrixXd products = MatrixXd::Zero(count, count);
  visit_products(A, X, count, [&](Index first, const TallMatrix& panel, const TallMatrix& image) {
    products.block(first, first, count - first, panel.cols()) = X.products(first, count, image);
  });
  return products.selfadjointView<Eigen::Lower>();
}

VectorXd lengths(const LongVectors& X, const Matrix& A) {
  VectorXd squares = VectorXd::Zero(X.capacity());
  visit_products(A, X, X.capacity(), [&](Index first, const TallMatrix& panel, const TallMatrix& image) {
    squares.segment(first, panel.cols()) = panel.cwiseProduct(image).colwise().sum();
  });
  return squares.cwiseMax(0.0).cwiseSqrt();
}

void project_out(const LongVectors& Q, const Matrix& A, LongVectors& X) {
  visit_products(A, X, X.capacity(), [&](Index first, Eigen::Ref<MatrixXd> panel, const TallMatrix& image) {
    Q.project_out(0, Q.capacity(), image, panel);
    X.put(first, panel);
  });
}

}  // namespace kalfem
