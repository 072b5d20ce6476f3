#include "kalfem/linalg/tall_matrices.hpp"

#include <gtest/gtest.h>

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Matrix = Eigen::SparseMatrix<double>;

/// Symmetric, with entries beside the diagonal and far from it; positive definite.
Matrix symmetric_matrix(Index n) {
  MatrixXd dense = 9.0 * MatrixXd::Identity(n, n);
  for (Index i = 0; i + 1 < n; ++i) dense(i, i + 1) = dense(i + 1, i) = 1.0 / double(i + 1);
  for (Index i = 0; i < n / 2; ++i) dense(i, n - 1 - i) = dense(n - 1 - i, i) = -2.0;
  return dense.sparseView();
}

void expect_near(const MatrixXd& found, const MatrixXd& expected) {
  ASSERT_EQ(found.rows(), expected.rows());
  ASSERT_EQ(found.cols(), expected.cols());
  EXPECT_LE((found - expected).norm(), 1e-14 * expected.norm());
}

// Widths around the eight columns that are multiplied at once, the narrow ones after the wide ones.
TEST(TallMatrices, AreMultipliedByASymmetricMatrix) {
  const Matrix A = symmetric_matrix(57);
  SymmetricProduct product(A);
  for (const Index width : {17, 16, 9, 8, 7, 1, 0}) {
    const MatrixXd X = MatrixXd::Random(57, width);
    MatrixXd Y = MatrixXd::Constant(57, width, 3.0);
    product.multiply(X, Y);
    expect_near(Y, MatrixXd(A) * X);
  }
}

TEST(TallMatrices, AreMultipliedInAPartOfALargerOne) {
  const Matrix A = symmetric_matrix(30);
  const MatrixXd X = MatrixXd::Random(41, 12);
  MatrixXd Y = MatrixXd::Zero(41, 14);
  SymmetricProduct(A).multiply(X.middleRows(5, 30), Y.block(7, 1, 30, 12));
  MatrixXd expected = MatrixXd::Zero(41, 14);
  expected.block(7, 1, 30, 12) = MatrixXd(A) * X.middleRows(5, 30);
  expect_near(Y, expected);
}

// More columns than are multiplied out at a time.
TEST(TallMatrices, HaveInnerProducts) {
  const Matrix A = symmetric_matrix(101);
  const MatrixXd X = MatrixXd::Random(101, 5), Y = MatrixXd::Random(101, 71);
  expect_near(inner_products(X, A, Y), X.transpose() * MatrixXd(A) * Y);
  expect_near(inner_products(Y, A, X), Y.transpose() * MatrixXd(A) * X);
  const MatrixXd own = gram(Y, A);
  expect_near(own, Y.transpose() * MatrixXd(A) * Y);
  EXPECT_EQ(own, MatrixXd(own.transpose()));
  expect_near(lengths(Y, A), own.diagonal().cwiseSqrt());
}

TEST(TallMatrices, AreZeroInTheMeasureOfAnEmptyMatrix) {
  const Matrix nothing(11, 11);
  const MatrixXd X = MatrixXd::Random(11, 3);
  EXPECT_EQ(inner_products(X, nothing, X.leftCols(2)), MatrixXd::Zero(3, 2));
  EXPECT_EQ(gram(X, nothing), MatrixXd::Zero(3, 3));
  EXPECT_EQ(lengths(X, nothing), VectorXd::Zero(3));
  EXPECT_EQ(gram(X.leftCols(0), symmetric_matrix(11)), MatrixXd(0, 0));
}

// More rows than are combined at a time.
TEST(TallMatrices, AreCombinedInTheirPlace) {
  const MatrixXd columns = MatrixXd::Random(20001, 9), weights = MatrixXd::Random(7, 5);
  MatrixXd X = columns;
  combine(X, weights);
  expect_near(X.leftCols(5), columns.leftCols(7) * weights);
  EXPECT_EQ(X.rightCols(2), columns.rightCols(2));
}

}  // namespace
}  // namespace kalfem
