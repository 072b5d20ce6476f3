// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/kernels/small_kernels.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <thread>

#include "kalfem/estimation/filter.hpp"
#include "kalfem/estimation/kernels/thin_kernels.hpp"
#include "kalfem/estimation/kernels/vector_lanes.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double epsilon = std::numeric_limits<double>::epsilon();

// Around the edges of tiles of 1 to 24 rows and 1 to 8 columns, of the narrow Cholesky (64), of the change from direct
// to packed products (160, at depth 321) and of the blocks of the packed ones (192 rows, depth 256).
const std::vector<Index> edge_sizes = {1,   2,   3,   4,   5,   6,   7,   8,   9,   11,  12,  13,  15,  16,
                                       17,  18,  23,  24,  25,  30,  31,  33,  40,  47,  48,  49,  63,  64,
                                       65,  66,  71,  79,  80,  81,  127, 128, 129, 130, 135, 159, 160, 161,
                                       167, 184, 191, 192, 193, 217, 255, 256, 257, 263, 321, 322, 390};

MatrixXd random_matrix(Index rows, Index columns, unsigned seed = 1) {
  std::mt19937_64 random(seed + static_cast<unsigned>(1000 * rows + columns));
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); });
}

/// Random, without meaning above the diagonal.
MatrixXd random_lower_half(Index n) {
  MatrixXd matrix = random_matrix(n, n, 3);
  matrix.triangularView<Eigen::StrictlyUpper>().setConstant(nan);
  return matrix;
}

MatrixXd random_lower(Index n) { return random_matrix(n, n, 4).triangularView<Eigen::Lower>(); }

enum class Compared { all, lower_triangle };

/// Two results of C + A B, each within (depth + 2) units in the last place of |C| + |A| |B| of the exact one [Higham,
/// Accuracy and Stability of Numerical Algorithms, 2002, (3.13)].
void expect_product(const MatrixXd& result, const MatrixXd& before, const MatrixXd& a, const MatrixXd& b, double sign,
                    Compared compared, const std::string& what) {
  const MatrixXd expected = before + sign * (a * b);
  const MatrixXd bound =
      2.0 * epsilon * static_cast<double>(a.cols() + 2) * (before.cwiseAbs() + a.cwiseAbs() * b.cwiseAbs());
  ASSERT_EQ(result.rows(), expected.rows()) << what;
  ASSERT_EQ(result.cols(), expected.cols()) << what;
  for (Index j = 0; j < result.cols(); ++j)
    for (Index i = compared == Compared::lower_triangle ? j : 0; i < result.rows(); ++i)
      ASSERT_LE(std::abs(result(i, j) - expected(i, j)), bound(i, j))
          << what << ", " << result.rows() << " x " << result.cols() << ", depth " << a.cols() << ", entry " << i
          << ", " << j;
}

void check_products(Index rows, Index columns, Index depth) {
  const MatrixXd a = random_matrix(rows, depth), b = random_matrix(depth, columns), c = random_matrix(columns, depth);
  const MatrixXd zero = MatrixXd::Zero(rows, columns), before = random_matrix(rows, columns, 2);
  MatrixXd out = MatrixXd::Constant(rows, columns, nan);
  multiply(a, b, out);
  expect_product(out, zero, a, b, 1.0, Compared::all, "multiply");
  out.setConstant(nan);
  multiply_transposed(a, c, out);
  expect_product(out, zero, a, c.transpose(), 1.0, Compared::all, "multiply_transposed");
  out = before;
  add_product_transposed(a, c, out);
  expect_product(out, before, a, c.transpose(), 1.0, Compared::all, "add_product_transposed");
}

void check_lower_factor(Index rows, Index n) {
  const MatrixXd a = random_matrix(rows, n), lower = random_lower(n);
  MatrixXd out = MatrixXd::Constant(rows, n, nan);
  multiply_lower(a, lower, out);
  expect_product(out, MatrixXd::Zero(rows, n), a, lower, 1.0, Compared::all, "multiply_lower");
}

void check_symmetric(Index n, Index depth) {
  const MatrixXd a = random_matrix(n, depth), before = random_lower_half(n);
  MatrixXd out = before;
  add_symmetric_product(a, a, out);
  expect_product(out, before, a, a.transpose(), 1.0, Compared::lower_triangle, "add_symmetric_product");
  const MatrixXd middle = random_matrix(depth, depth, 5), b = a * (middle + middle.transpose());
  out = before;
  add_symmetric_product(b, a, out);
  expect_product(out, before, b, a.transpose(), 1.0, Compared::lower_triangle, "add_symmetric_product of two");
  out = before;
  subtract_square(a, out);
  expect_product(out, before, a, a.transpose(), -1.0, Compared::lower_triangle, "subtract_square");
}

/// Lower triangular with pivots of the size of the variances.
MatrixXd well_conditioned_root(Index n) {
  MatrixXd root = random_lower(n) / std::sqrt(static_cast<double>(n));
  root.diagonal().array() = root.diagonal().array().abs() + 0.5;
  return root;
}

/// P of which only the lower triangle has a meaning.
MatrixXd covariance_of(const MatrixXd& root) {
  MatrixXd covariance = root * root.transpose();
  covariance.triangularView<Eigen::StrictlyUpper>().setConstant(nan);
  return covariance;
}

/// Positions of pivots in all parts of a factorisation by halves.
std::vector<Index> places(Index n) {
  std::vector<Index> result = {0, n / 4, n / 2, n / 2 + 1, 3 * n / 4, n - 1};
  std::erase_if(result, [n](Index k) { return k >= n; });
  return result;
}

TEST(SmallKernels, SquareProductsAtAllEdges) {
  for (const Index n : edge_sizes) {
    check_products(n, n, n);
    check_lower_factor(n, n);
    check_symmetric(n, n);
  }
}

TEST(SmallKernels, RectangularProducts) {
  const std::vector<Index> few = {1, 4, 7, 30, 39, 40, 41, 90, 161, 263};
  for (const Index rows : few)
    for (const Index columns : few)
      for (const Index depth : few) check_products(rows, columns, depth);
}

TEST(SmallKernels, LowerFactorWithOtherRows) {
  for (const Index rows : {1, 3, 4, 5, 8, 39, 40, 41, 77, 193, 400})
    for (const Index n : {1, 5, 6, 7, 13, 64, 160, 161, 162, 255, 256, 257, 520}) check_lower_factor(rows, n);
}

TEST(SmallKernels, SymmetricProductsOfOtherDepth) {
  for (const Index n : {1, 4, 6, 9, 24, 31, 64, 160, 161, 165, 192, 193, 200, 217, 385})
    for (const Index depth : {1, 2, 4, 39, 40, 41, 129, 256, 257, 320, 321, 322, 513}) check_symmetric(n, depth);
}

TEST(SmallKernels, EmptyProducts) {
  check_products(5, 3, 0);
  check_products(0, 3, 4);
  check_symmetric(7, 0);
}

// |P - L L^T| <= (n + 1) units in the last place of |L| |L^T| [Higham 2002, theorem 10.3].
TEST(SmallKernels, CholeskyAtAllEdges) {
  for (const Index n : edge_sizes) {
    const MatrixXd p = covariance_of(well_conditioned_root(n));
    MatrixXd lower = MatrixXd::Constant(n, n, nan);
    ASSERT_TRUE(cholesky(p, 1e-13, lower)) << n;
    ASSERT_TRUE(lower.triangularView<Eigen::StrictlyUpper>().toDenseMatrix().isZero(0.0)) << n;
    const MatrixXd product = lower * lower.transpose();
    const MatrixXd bound =
        2.0 * epsilon * static_cast<double>(n + 1) * (lower.cwiseAbs() * lower.cwiseAbs().transpose());
    for (Index j = 0; j < n; ++j)
      for (Index i = j; i < n; ++i) ASSERT_LE(std::abs(product(i, j) - p(i, j)), bound(i, j)) << n << ": " << i << j;
  }
}

// Pivots are compared with the variances of P, not with what is left of them where they are reached.
TEST(SmallKernels, CholeskyRefusesSmallPivots) {
  constexpr double floor = 1e-4;
  for (const Index n : {2, 5, 24, 63, 64, 65, 130, 200, 257})
    for (const Index k : places(n)) {
      if (k == 0) continue;  // the first pivot is its variance
      MatrixXd root = well_conditioned_root(n), lower;
      const double rest = root.row(k).head(k).squaredNorm();
      for (const double share : {0.5 * floor, 2.0 * floor}) {
        root(k, k) = std::sqrt(rest * share / (1.0 - share));  // pivot = share of the variance
        EXPECT_EQ(cholesky(covariance_of(root), floor, lower), share > floor) << n << ", pivot " << k;
      }
    }
}

TEST(SmallKernels, CholeskyRefusesIndefiniteAndUndefined) {
  for (const Index n : {1, 3, 4, 24, 64, 65, 161, 257})
    for (const Index k : places(n)) {
      MatrixXd p = covariance_of(well_conditioned_root(n)), lower;
      const double variance = p(k, k);
      for (const double wrong : {-variance, 0.0, nan}) {
        p(k, k) = wrong;
        EXPECT_FALSE(cholesky(p, 0.0, lower)) << n << ", pivot " << k << ", " << wrong;
      }
      p(k, k) = variance;
      p(n - 1, k) = nan;
      EXPECT_FALSE(cholesky(p, 0.0, lower)) << n << ", below pivot " << k;
    }
}

// What comes after the refused pivot is well, and must not hide it.
TEST(SmallKernels, CholeskyRefusesOneNegativeVarianceOfADiagonalMatrix) {
  for (const Index n : {1, 4, 24, 64, 65, 161, 257})
    for (const Index k : places(n)) {
      MatrixXd p = MatrixXd::Identity(n, n), lower;
      p(k, k) = -1.0;
      EXPECT_FALSE(cholesky(p, 0.0, lower)) << n << ", pivot " << k;
    }
}

TEST(SmallKernels, SolveOnTheRight) {
  for (const Index columns : {1, 2, 4, 7})
    for (const Index rows : {1, 5, 24, 200}) {
      const MatrixXd lower = well_conditioned_root(columns), solution = random_matrix(rows, columns);
      MatrixXd b = solution * lower.transpose();
      solve_on_the_right(lower, b);
      EXPECT_TRUE(b.isApprox(solution, 1e-13)) << rows << " x " << columns;  // condition numbers of about 10
    }
}

// The copies of the packed products belong to a thread.
TEST(SmallKernels, ThreadsDoNotDisturbEachOther) {
  std::vector<std::thread> threads;
  for (const Index n : {170, 200, 300})
    threads.emplace_back([n] {
      for (int i = 0; i < 5; ++i) check_symmetric(n, n);
    });
  for (auto& thread : threads) thread.join();
}

/// Rows of X^T that fill no register, with one, an even and an odd number of columns beside them.
TEST(ThinKernels, InnerProductsAreThoseOfPlainLoops) {
  for (const Index columns : {1, 5, 8, 11, 16})
    for (const Index beside : {1, 4, 7}) {
      const MatrixXd x = random_matrix(24, columns), y = random_matrix(24, beside);
      const Index padded = whole_lanes(columns);
      MatrixXd transposed = MatrixXd::Zero(padded, 24), m = MatrixXd::Constant(padded, beside, nan);
      transposed.topRows(columns) = x.transpose();
      thin_inner(transposed, y, m);
      expect_product(m.topRows(columns), MatrixXd::Zero(columns, beside), x.transpose(), y, 1.0, Compared::all,
                     "inner");
      EXPECT_TRUE(m.bottomRows(padded - columns).isZero(0.0));
    }
}

/// On either side of the number of columns from which blocks pay.
TEST(Gain, TimesTheFactorIsTheWhitenedCovariance) {
  for (const Index channels : {1, 4, 16, 17, 40}) {
    const MatrixXd cross = random_matrix(24, channels);
    const MatrixXd lower = random_lower(channels) + 10.0 * MatrixXd::Identity(channels, channels);
    EXPECT_TRUE((gain_from(cross, lower) * lower).isApprox(cross, 1e-12)) << channels;
  }
}

}  // namespace
}  // namespace kalfem
