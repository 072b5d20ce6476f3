// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/sparse_operations.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Sparse = Eigen::SparseMatrix<double>;

constexpr Index rows = 60, columns = 50;

/// Entries in a part `fill` of all places, others in each matrix of the same fill.
MatrixXd random_matrix(double fill, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> part(0.0, 1.0), value(-1.0, 1.0);
  return MatrixXd::NullaryExpr(rows, columns, [&] { return part(random) < fill ? value(random) : 0.0; });
}

TEST(PairedProduct, IsTheSumOfBothHoweverFullTheyAre) {
  const VectorXd u = VectorXd::LinSpaced(columns, -1.0, 2.0), v = VectorXd::LinSpaced(columns, 3.0, -1.0);
  VectorXd y;
  for (const double fill_a : {0.0, 0.02, 0.2, 1.0})
    for (const double fill_b : {0.02, 0.2, 1.0}) {
      const MatrixXd a = random_matrix(fill_a, 1), b = random_matrix(fill_b, 2);
      PairedProduct(a.sparseView(), b.sparseView()).multiply(u, v, y);
      // rounding of sums of 50 terms; found 3e-16 of the norms
      EXPECT_LT((y - (a * u + b * v)).norm(), 2e-15 * (a.norm() + b.norm())) << fill_a << ", " << fill_b;
    }
}

TEST(PairedProduct, WithoutASecondMatrixItsVectorIsNotRead) {
  const VectorXd u = VectorXd::LinSpaced(columns, -1.0, 2.0);
  const VectorXd nan = VectorXd::Constant(columns, std::numeric_limits<double>::quiet_NaN());
  VectorXd y;
  for (const double fill : {0.02, 1.0}) {
    const MatrixXd a = random_matrix(fill, 1);
    PairedProduct(a.sparseView(), Sparse(rows, columns)).multiply(u, nan, y);
    // rounding of sums of 50 terms
    EXPECT_LT((y - a * u).norm(), 2e-15 * a.norm()) << fill;
  }
}

}  // namespace
}  // namespace kalfem
