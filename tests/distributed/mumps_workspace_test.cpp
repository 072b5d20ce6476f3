// SPDX-License-Identifier: Apache-2.0
#include "kalfem/distributed/mumps_workspace.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "kalfem/linalg/makers.hpp"
#include "reduction/lattice.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

SparseMatrix membrane(double support) {
  return lattice::model({.columns = 40, .rows = 25, .support = support}).stiffness;
}

// CHOLMOD counts the zeros of its supernodes, or L without them: either is another number.
TEST(MumpsWorkspace, IsBehindTheFactor) {
  const SparseFactor distributed(membrane(50.0));
  auto makers = use_makers({});
  const SparseFactor serial(membrane(50.0));
  use_makers(std::move(makers));
  EXPECT_NE(distributed.nonzeros(), serial.nonzeros());
  EXPECT_NEAR(distributed.smallest_pivot() / serial.smallest_pivot(), 1.0, 0.1);  // of orders within one front
  EXPECT_EQ(distributed.order(), serial.order());
}

TEST(MumpsWorkspace, NamesAColumnOfTheMotionWithNegativeEnergy) {
  SparseMatrix matrix = membrane(50.0);
  const Index node = 12 * 25 + 7;
  matrix.coeffRef(node, node) *= 0.3;  // still positive, but not with its neighbours
  try {
    const SparseFactor factor(matrix);
    ADD_FAILURE() << "an indefinite matrix was accepted";
  } catch (const NotPositiveDefinite& error) {
    EXPECT_EQ(error.column(), node);
  }
}

TEST(MumpsWorkspace, FactorsAgainAfterASingularMatrix) {
  SparseFactor factor(membrane(50.0));
  SparseMatrix singular = membrane(50.0);
  for (Index y = 0; y < 25; ++y) singular.coeffRef(y, y) -= 50.0;  // the supports
  EXPECT_THROW(factor.refactor(singular), NotPositiveDefinite);
  factor.refactor(2.0 * membrane(50.0));
  const MatrixXd loads = MatrixXd::Random(1000, 40);
  EXPECT_LT((2.0 * (membrane(50.0) * factor.solve(loads)) - loads).norm(), 1e-10 * loads.norm());
}

TEST(MumpsWorkspace, FactorsLiveSideBySide) {
  std::vector<SparseFactor> factors;
  for (const double support : {1.0, 10.0, 100.0}) factors.emplace_back(membrane(support));
  factors.erase(factors.begin() + 1);
  const VectorXd load = VectorXd::Ones(1000);
  EXPECT_LT((membrane(1.0) * factors[0].solve(load) - load).norm(), 1e-8);
  EXPECT_LT((membrane(100.0) * factors[1].solve(load) - load).norm(), 1e-8);
}

TEST(MumpsWorkspace, ThreadsTakeTurns) {
  const MatrixXd loads = MatrixXd::Random(1000, 3);
  const MatrixXd expected = SparseFactor(membrane(7.0)).solve(loads);
  std::vector<MatrixXd> solutions(4);
  std::vector<std::thread> threads;
  for (auto& solution : solutions) threads.emplace_back([&] { solution = SparseFactor(membrane(7.0)).solve(loads); });
  for (auto& thread : threads) thread.join();
  for (const auto& solution : solutions) EXPECT_LT((solution - expected).norm(), 1e-10 * expected.norm());
}

}  // namespace
}  // namespace kalfem
