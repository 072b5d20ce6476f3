// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/tall_matrices.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "linalg/near.hpp"
#include "linalg/symmetric_matrix.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using test::expect_near;
using test::symmetric_matrix;
using Matrix = Eigen::SparseMatrix<double>;

// Widths around the eight columns that are multiplied at once, the narrow ones after the wide ones.
TEST(TallMatrices, AreMultipliedByASymmetricMatrix) {
  const Matrix A = symmetric_matrix(57);
  SymmetricProduct product(A);
  for (const Index width : {17, 16, 9, 8, 7, 1, 0}) {
    const MatrixXd X = MatrixXd::Random(57, width);
    MatrixXd Y = MatrixXd::Constant(57, width, 3.0);
    product.multiply(X, Y);
    expect_near(Y, MatrixXd(A) * X);
    MatrixXd in_place = X;
    product.multiply(in_place, in_place);
    EXPECT_EQ(in_place, Y);
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

TEST(TallMatrices, AreWorkedOnInPanelsOfAboutEqualWidth) {
  std::vector<Index> widths;
  for (const Index columns : {0, 1, 32, 33, 65}) {
    Index end = 0;
    by_panels(columns, 32, [&](Index first, Index width) {
      EXPECT_EQ(first, end);
      end += width;
      widths.push_back(width);
    });
    EXPECT_EQ(end, columns);
  }
  EXPECT_EQ(widths, (std::vector<Index>{1, 32, 16, 17, 21, 22, 22}));
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
