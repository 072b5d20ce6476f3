// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/long_products.hpp"

#include <gtest/gtest.h>

#include "linalg/near.hpp"
#include "linalg/symmetric_matrix.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::expect_near;
using test::symmetric_matrix;
using Matrix = Eigen::SparseMatrix<double>;

// More vectors than are multiplied at a time, in all of these.
TEST(LongProducts, AreShownPanelByPanel) {
  const Matrix A = symmetric_matrix(101);
  const MatrixXd columns = MatrixXd::Random(101, 71);
  const auto X = make_long_vectors(columns);
  MatrixXd products(101, 40);
  visit_products(A, *X, 40, [&](Index first, const LongVectors::Columns& panel, const LongVectors::Columns& product) {
    EXPECT_EQ(panel, columns.middleCols(first, panel.cols()));
    products.middleCols(first, product.cols()) = product;
  });
  expect_near(products, MatrixXd(A) * columns.leftCols(40));
}

TEST(LongProducts, AddUpToGramMatricesAndLengths) {
  const Matrix A = symmetric_matrix(101);
  const MatrixXd columns = MatrixXd::Random(101, 71), expected = columns.transpose() * MatrixXd(A) * columns;
  const auto X = make_long_vectors(columns);
  const MatrixXd all = gram(*X, A, 71);
  expect_near(all, expected);
  EXPECT_EQ(all, MatrixXd(all.transpose()));
  expect_near(gram(*X, A, 33), expected.topLeftCorner(33, 33));
  expect_near(lengths(*X, A), expected.diagonal().cwiseSqrt());
}

TEST(LongProducts, AreZeroWithAnEmptyMatrix) {
  const Matrix nothing(11, 11);
  const auto X = make_long_vectors(MatrixXd::Random(11, 3));
  EXPECT_EQ(gram(*X, nothing, 3), MatrixXd::Zero(3, 3));
  EXPECT_EQ(lengths(*X, nothing), VectorXd::Zero(3));
  EXPECT_EQ(gram(*X, symmetric_matrix(11), 0), MatrixXd(0, 0));
}

TEST(LongProducts, ProjectVectorsOutOfOthers) {
  const Matrix A = symmetric_matrix(101);
  const MatrixXd kept = MatrixXd::Random(101, 9), columns = MatrixXd::Random(101, 40);
  const auto Q = make_long_vectors(kept), X = make_long_vectors(columns);
  project_out(*Q, A, *X);
  expect_near(X->columns(0, 40), columns - kept * (kept.transpose() * MatrixXd(A) * columns));
}

TEST(LongProducts, LeaveVectorsAsTheyAreBesideNone) {
  const MatrixXd columns = MatrixXd::Random(11, 3);
  const auto none = make_long_vectors(11), X = make_long_vectors(columns);
  project_out(*none, symmetric_matrix(11), *X);
  EXPECT_EQ(X->columns(0, 3), columns);
  project_out(*X, symmetric_matrix(11), *none);
  EXPECT_EQ(none->capacity(), 0);
}

}  // namespace
}  // namespace kalfem
