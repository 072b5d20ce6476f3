// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/sparse_factor.hpp"

#include <SuiteSparse_config.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <random>
#include <tuple>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/linalg/single_precision_factor.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::SparseMatrix;
using Eigen::VectorXd;

/// Springs of stiffness 1 between neighbours on a side x side grid, each node held by a spring `support`.
SparseMatrix<double> grid(Index side, double support) {
  SparseMatrix<double> matrix(side * side, side * side);
  std::vector<Eigen::Triplet<double>> entries;
  const auto spring = [&](Index a, Index b) {
    for (const auto& [i, j, k] : {std::tuple{a, a, 1.0}, {b, b, 1.0}, {a, b, -1.0}, {b, a, -1.0}})
      entries.emplace_back(i, j, k);
  };
  for (Index y = 0; y < side; ++y)
    for (Index x = 0; x < side; ++x) {
      const Index node = y * side + x;
      entries.emplace_back(node, node, support);
      if (x + 1 < side) spring(node, node + 1);
      if (y + 1 < side) spring(node, node + side);
    }
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

/// A A^T + I with random sparse A: fills so much that the factor is supernodal.
SparseMatrix<double> random_definite(Index size) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> value(-1.0, 1.0);
  std::uniform_int_distribution<Index> place(0, size - 1);
  SparseMatrix<double> factor(size, size), identity(size, size);
  for (Index k = 0; k < 4 * size; ++k) factor.coeffRef(place(random), place(random)) = value(random);
  identity.setIdentity();
  return SparseMatrix<double>(factor * factor.transpose()) + identity;
}

TEST(SparseFactor, AnOrderServesForAnotherMatrixOfThePattern) {
  const SparseFactor first(grid(30, 0.1));
  const auto matrix = grid(30, 0.7);
  const SparseFactor found(matrix), again(matrix, first.order());
  EXPECT_EQ(again.order(), first.order());
  EXPECT_EQ(again.nonzeros(), first.nonzeros());
  const MatrixXd right_side = MatrixXd::Random(matrix.rows(), 3);
  // rounding: the same order gives the same operations
  EXPECT_LT((again.solve(right_side) - found.solve(right_side)).norm(), 1e-14 * right_side.norm());
  EXPECT_THROW(SparseFactor(grid(20, 0.1), first.order()), InvalidInput);
}

TEST(SparseFactor, SolvesAsTheDenseFactorDoes) {
  for (const auto& matrix : {random_definite(300), grid(12, 0.1), grid(60, 0.1)}) {
    const SparseFactor factor(matrix);
    const MatrixXd right_side = MatrixXd::Random(matrix.rows(), 5);
    const MatrixXd solution = factor.solve(right_side);
    // backward-stable: rounding, whatever the condition; found 9e-16
    EXPECT_LT((matrix * solution - right_side).norm() / right_side.norm(), 1e-14);
    if (matrix.rows() > 1000) continue;
    const MatrixXd dense = MatrixXd(matrix).llt().solve(right_side);
    EXPECT_LT((solution - dense).norm() / dense.norm(), 2e-14);  // rounding, times a condition number below 1e3
  }
}

// More columns than are solved for at once, in panels of 24, 24 and 22.
TEST(SparseFactor, SolvesForManyColumns) {
  for (const auto& matrix : {random_definite(300), grid(12, 0.1)}) {
    const SparseFactor factor(matrix);
    const MatrixXd right_side = MatrixXd::Random(matrix.rows(), 70);
    MatrixXd solution = right_side;
    factor.solve(solution, solution);
    EXPECT_LT((matrix * solution - right_side).norm() / right_side.norm(), 1e-14);
    EXPECT_LT((factor.solve(right_side) - solution).norm(), 2e-14 * solution.norm());  // rounding
  }
}

TEST(SparseFactor, SolvesIntoBlocksAndInPlace) {
  const SparseMatrix<double> matrix = grid(15, 0.5);
  const SparseFactor factor(matrix);
  const MatrixXd right_side = MatrixXd::Random(225, 6);
  const MatrixXd expected = factor.solve(right_side);
  const double rounding = 3e-15;
  MatrixXd larger = MatrixXd::Constant(300, 6, 9.0);
  factor.solve(right_side, larger.middleRows(40, 225));
  EXPECT_LT((larger.middleRows(40, 225) - expected).norm(), rounding * expected.norm());
  EXPECT_EQ(larger.topRows(40).minCoeff(), 9.0);
  EXPECT_EQ(larger.bottomRows(35).maxCoeff(), 9.0);
  factor.solve(larger.middleRows(40, 225), larger.middleRows(40, 225));
  EXPECT_LT((larger.middleRows(40, 225) - factor.solve(expected)).norm(), rounding * expected.norm());
  MatrixXd in_place = right_side;
  factor.solve(in_place, in_place);
  EXPECT_LT((in_place - expected).norm(), rounding * expected.norm());
}

TEST(SparseFactor, SolvesInSinglePrecision) {
  const auto matrix = random_definite(300);
  auto single = SparseFactor(matrix).in_single_precision();
  ASSERT_TRUE(single);
  VectorXd right_side = VectorXd::Random(300), solution;
  for (const double unit : {1.0, 1e-60, 1e60}) {  // beyond what single precision can hold
    single->solve(unit * right_side, solution);
    // backward-stable: rounding of single precision; found 2e-7
    EXPECT_LT((matrix * solution - unit * right_side).norm() / (unit * right_side).norm(), 3e-6);
    EXPECT_GT((matrix * solution - unit * right_side).norm() / (unit * right_side).norm(), 1e-10);
  }
  single->solve(VectorXd::Zero(300), solution);
  EXPECT_EQ(solution, VectorXd::Zero(300));
}

TEST(SparseFactor, HasNoSinglePrecisionWhereItIsNotSupernodal) {
  EXPECT_FALSE(SparseFactor(grid(12, 0.1)).in_single_precision());
}

TEST(SparseFactor, ReadsTheUpperTriangleOnly) {
  const SparseMatrix<double> matrix = grid(9, 0.3);
  const SparseMatrix<double> upper = matrix.triangularView<Eigen::Upper>();
  const VectorXd right_side = VectorXd::LinSpaced(81, -1.0, 2.0);
  EXPECT_LT((SparseFactor(matrix).solve(right_side) - SparseFactor(upper).solve(right_side)).norm(),
            1e-14);  // the same operations
}

TEST(SparseFactor, RefactorsValuesOfTheSamePattern) {
  const SparseMatrix<double> matrix = grid(20, 0.2);
  SparseFactor factor(matrix);
  const VectorXd right_side = VectorXd::Ones(400);
  factor.refactor(3.0 * matrix);
  // rounding: found 8e-14 of right sides of norm 20
  EXPECT_LT((3.0 * (matrix * factor.solve(right_side)) - right_side).norm(), 1e-12);
  EXPECT_THROW(factor.refactor(grid(21, 0.2)), InvalidInput);
  SparseMatrix<double> another = matrix;
  another.coeffRef(0, 399) = 1e-3;
  EXPECT_THROW(factor.refactor(another), InvalidInput);
  EXPECT_THROW(factor.refactor(grid(20, 0.0)), NotPositiveDefinite);
  factor.refactor(matrix);
  EXPECT_LT((matrix * factor.solve(right_side) - right_side).norm(), 1e-12);  // as above
}

TEST(SparseFactor, NamesTheColumnThatSpoilsIt) {
  // A node of its own with a negative, zero or undefined spring: no other column can be to blame, wherever the
  // ordering puts it.
  for (const double wrong : {-1.0, 0.0, std::nan("")})
    for (const Index column : {0, 17, 143, 3000}) {
      SparseMatrix<double> matrix = grid(60, 0.1);
      matrix.prune([&](Index i, Index j, double) { return i != column && j != column; });
      matrix.coeffRef(column, column) = wrong;
      try {
        const SparseFactor factor(matrix);
        ADD_FAILURE() << "a pivot of " << wrong << " was accepted";
      } catch (const NotPositiveDefinite& error) {
        EXPECT_EQ(error.column(), column) << wrong;
      }
    }
}

TEST(SparseFactor, ASingularMatrixIsFoundThoughRoundingHidesIt) {
  // springs without support: the last pivot is zero but for rounding, of either sign
  for (const Index side : {2, 3, 10, 31, 60, 100}) {
    SparseMatrix<double> matrix = grid(side, 0.0);
    const VectorXd units = VectorXd::NullaryExpr(matrix.rows(), [](Index i) { return std::pow(10.0, double(i % 7)); });
    EXPECT_THROW(SparseFactor{matrix}, NotPositiveDefinite) << side;
    matrix = units.asDiagonal() * matrix * units.asDiagonal();
    EXPECT_THROW(SparseFactor{matrix}, NotPositiveDefinite) << side;
  }
}

TEST(SparseFactor, SpringsHoldRowsThatTheMatrixDoesNotStore) {
  SparseMatrix<double> matrix = grid(30, 0.5);
  matrix.prune([](Index i, Index j, double) { return i % 7 != 0 && j % 7 != 0; });
  const VectorXd springs = VectorXd::LinSpaced(900, 1.0, 2.0), load = VectorXd::LinSpaced(900, -1.0, 3.0);
  const MatrixXd held = MatrixXd(matrix) + MatrixXd(springs.asDiagonal());
  const VectorXd expected = held.llt().solve(load);
  EXPECT_LT((SparseFactor(matrix, {}, springs).solve(load) - expected).norm(), 1e-12 * expected.norm());
}

TEST(SparseFactor, AnIllConditionedMatrixIsNotSingular) {
  // a long chain fixed at one end: the flexibility of its tip is the number of springs
  SparseMatrix<double> chain(4000, 4000);
  for (Index i = 0; i < chain.rows(); ++i) {
    chain.coeffRef(i, i) = i + 1 < chain.rows() ? 2.0 : 1.0;
    if (i > 0) chain.coeffRef(i, i - 1) = chain.coeffRef(i - 1, i) = -1.0;
  }
  const SparseFactor factor(chain);
  const VectorXd displacement = factor.solve(VectorXd::Unit(4000, 3999));
  EXPECT_NEAR(displacement[3999], 4000.0, 1e-7);  // found exact; the condition 6e6 allows 1e-5
  EXPECT_GT(factor.nonzeros(), 7.9e3);
  EXPECT_GT(factor.bytes(), 8.0 * factor.nonzeros());
}

int allocations = 0;
void* counting_malloc(std::size_t bytes) { return ++allocations, std::malloc(bytes); }
void* counting_calloc(std::size_t count, std::size_t bytes) { return ++allocations, std::calloc(count, bytes); }
void* counting_realloc(void* memory, std::size_t bytes) { return ++allocations, std::realloc(memory, bytes); }

TEST(SparseFactor, SolvingAgainDoesNotAllocate) {
  SuiteSparse_config.malloc_func = counting_malloc;
  SuiteSparse_config.calloc_func = counting_calloc;
  SuiteSparse_config.realloc_func = counting_realloc;
  for (const auto& matrix : {random_definite(300), grid(40, 0.1)}) {  // supernodal and simplicial
    const SparseFactor factor(matrix);
    const MatrixXd right_side = MatrixXd::Random(matrix.rows(), 7);
    MatrixXd solution = factor.solve(right_side);
    factor.solve(right_side.col(0), solution.col(0));
    EXPECT_GT(allocations, 0);
    allocations = 0;
    for (int repeat = 0; repeat < 3; ++repeat) {
      factor.solve(right_side, solution);
      factor.solve(right_side.col(2), solution.col(2));
    }
    EXPECT_EQ(allocations, 0);
  }
  SuiteSparse_config.malloc_func = std::malloc;
  SuiteSparse_config.calloc_func = std::calloc;
  SuiteSparse_config.realloc_func = std::realloc;
}

TEST(SparseFactor, EdgesOfTheRange) {
  const SparseFactor nothing(SparseMatrix<double>(0, 0));
  EXPECT_EQ(nothing.solve(MatrixXd(0, 3)).rows(), 0);
  EXPECT_THROW(SparseFactor(SparseMatrix<double>(2, 3)), InvalidInput);
  SparseFactor first(grid(5, 1.0));
  SparseFactor second = std::move(first);
  EXPECT_EQ(second.size(), 25);
  EXPECT_EQ(second.solve(MatrixXd(25, 0)).cols(), 0);
}

}  // namespace
}  // namespace kalfem
