// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/stiffness_factor.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "kalfem/linalg/lowest_modes.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::SparseMatrix;
using Eigen::VectorXd;

/// Chains of unit springs side by side, free at their ends, of `size` masses each.
SparseMatrix<double> free_chains(Index count, Index size) {
  std::vector<Eigen::Triplet<double>> entries;
  for (Index c = 0; c < count; ++c)
    for (Index i = 0; i + 1 < size; ++i) {
      const Index a = c * size + i, b = a + 1;
      entries.emplace_back(a, a, 1.0), entries.emplace_back(b, b, 1.0);
      entries.emplace_back(a, b, -1.0), entries.emplace_back(b, a, -1.0);
    }
  SparseMatrix<double> matrix(count * size, count * size);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

SparseMatrix<double> masses(Index size) {
  return SparseMatrix<double>(VectorXd::LinSpaced(size, 1.0, 2.0).asDiagonal());
}

TEST(StiffnessFactor, AHeldFactorAnswersLoadsInEquilibrium) {
  const Index n = 500;
  const SparseMatrix<double> K = free_chains(1, n), M = masses(n);
  const auto held = factor_held(K, M, MatrixXd::Constant(n, 1, 3.0));
  ASSERT_TRUE(held);
  EXPECT_FALSE(held->regular());
  EXPECT_NEAR((held->rigid_modes.transpose() * (M * held->rigid_modes))(0, 0), 1.0, 1e-14);

  const MatrixXd loads = MatrixXd::Identity(n, 2);
  MatrixXd displacements(n, 2);
  held->respond(loads, displacements);
  const MatrixXd balanced = loads - held->rigid_momentum * (held->rigid_modes.transpose() * loads);
  EXPECT_LT((K * displacements - balanced).cwiseAbs().maxCoeff(), 1e-11);                     // condition n^2
  EXPECT_LT((held->rigid_momentum.transpose() * displacements).cwiseAbs().maxCoeff(), 1e-9);  // |U| is 1e4
}

TEST(StiffnessFactor, AFurtherMotionWithoutStrainHasNoHeldFactor) {
  const Index n = 50;
  const SparseMatrix<double> K = free_chains(2, n), M = masses(2 * n);
  EXPECT_FALSE(factor_held(K, M, MatrixXd::Ones(2 * n, 1))) << "both chains as one body";
  MatrixXd each = MatrixXd::Zero(2 * n, 2);
  each.col(0).head(n).setOnes();
  each.col(1).tail(n).setOnes();
  EXPECT_TRUE(factor_held(K, M, each));
  EXPECT_FALSE(factor_held(-K, M, each)) << "indefinite";
  EXPECT_FALSE(factor_held(K, SparseMatrix<double>(2 * n, 2 * n), each)) << "no mass, so no rigid-body mode";
}

// The rigid-body modes are known, the elastic ones come from the held stiffness without a shift: the same as those of
// K + s M, by both checks of completeness and where fewer modes are asked for than there are rigid ones.
TEST(StiffnessFactor, ModesOfAFreeBodyDoNotDependOnTheFactor) {
  for (const Index n : {150, 1000, 4000})
    for (const Index count : {1, 2, 9}) {
      const SparseMatrix<double> K = free_chains(1, n), M = masses(n);
      const auto held = factor_held(K, M, MatrixXd::Ones(n, 1));
      ASSERT_TRUE(held);
      const LowestModes by_shift = lowest_modes(K, M, {.count = count});
      const LowestModes by_support = lowest_modes(K, M, *held, {.count = count});
      ASSERT_EQ(by_support.values.size(), count);
      EXPECT_EQ(by_support.values[0], 0.0);
      for (Index i = 1; i < count; ++i) EXPECT_NEAR(by_support.values[i] / by_shift.values[i], 1.0, 1e-9) << n;
      EXPECT_NEAR(by_support.next.value() / by_shift.next.value(), 1.0, 0.02);
      const MatrixXd gram = by_support.vectors.transpose() * (M * by_shift.vectors);
      EXPECT_LT((gram.cwiseAbs() - MatrixXd::Identity(count, count)).cwiseAbs().maxCoeff(), 1e-7) << n;
    }
}

TEST(StiffnessFactor, ModesBelowALimitIncludeTheRigidOnes) {
  const Index n = 4000;
  const SparseMatrix<double> K = free_chains(1, n), M = masses(n);
  const auto held = factor_held(K, M, MatrixXd::Ones(n, 1));
  ASSERT_TRUE(held);
  const LowestModes six = lowest_modes(K, M, {.count = 6});
  const double limit = 0.5 * (six.values[4] + six.values[5]);
  EXPECT_EQ(lowest_modes(K, M, *held, {.below = limit}).values.size(), 5);
  EXPECT_EQ(lowest_modes(K, M, *held, {.count = 3, .below = limit}).values.size(), 3);
}

}  // namespace
}  // namespace kalfem
