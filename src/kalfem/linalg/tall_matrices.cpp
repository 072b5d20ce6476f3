#include "kalfem/linalg/tall_matrices.hpp"

#include <algorithm>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
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

void visit_products(const Matrix& A, const TallMatrix& X,
                    const std::function<void(Index first, const TallMatrix& product)>& visit) {
  constexpr Index panel = 32;
  if (A.nonZeros() == 0 || X.cols() == 0) return;
  SymmetricProduct product(A);
  MatrixXd image(X.rows(), std::min(panel, X.cols()));
  for (Index first = 0; first < X.cols(); first += panel) {
    auto part = image.leftCols(std::min(panel, X.cols() - first));
    product.multiply(X.middleCols(first, part.cols()), part);
    visit(first, part);
  }
}

MatrixXd inner_products(const TallMatrix& X, const Matrix& A, const TallMatrix& Y) {
  MatrixXd products = MatrixXd::Zero(X.cols(), Y.cols());
  visit_products(A, Y, [&](Index first, const TallMatrix& image) {
    products.middleCols(first, image.cols()).noalias() = X.transpose() * image;
  });
  return products;
}

MatrixXd gram(const TallMatrix& X, const Matrix& A) {
  MatrixXd products = MatrixXd::Zero(X.cols(), X.cols());
  visit_products(A, X, [&](Index first, const TallMatrix& image) {
    const Index below = X.cols() - first;
    products.block(first, first, below, image.cols()).noalias() = X.rightCols(below).transpose() * image;
  });
  return products.selfadjointView<Eigen::Lower>();
}

VectorXd lengths(const TallMatrix& X, const Matrix& A) {
  VectorXd squares = VectorXd::Zero(X.cols());
  visit_products(A, X, [&](Index first, const TallMatrix& image) {
    squares.segment(first, image.cols()) = X.middleCols(first, image.cols()).cwiseProduct(image).colwise().sum();
  });
  return squares.cwiseMax(0.0).cwiseSqrt();
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
