// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/block_diagonal_form.hpp"

#include <gtest/gtest.h>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/random.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

MatrixXd random_matrix(std::uint64_t seed, Index rows, Index columns) {
  RandomStream random(seed, "block diagonal form");
  return MatrixXd::NullaryExpr(rows, columns, [&] { return random.normal(); });
}

/// x' = A x of damped oscillators with a full damping matrix: non-proportional.
MatrixXd oscillators(const Eigen::VectorXd& frequencies, const MatrixXd& damping) {
  const Index n = frequencies.size();
  MatrixXd A = MatrixXd::Zero(2 * n, 2 * n);
  A.topRightCorner(n, n).setIdentity();
  A.bottomLeftCorner(n, n) = -MatrixXd(frequencies.cwiseAbs2().asDiagonal());
  A.bottomRightCorner(n, n) = -damping;
  return A;
}

MatrixXd full_damping(std::uint64_t seed, Index n, double size) {
  const MatrixXd random = random_matrix(seed, n, n);
  return size * (random * random.transpose());
}

/// T B = A T to rounding, B zero outside its blocks, T^-1 its inverse. Rounding is magnified by the splitting, by up to
/// 1e4: found 2.6e-12 of each row's own size, and 2.8e-10 in the inverse.
void expect_form(const MatrixXd& A, const BlockDiagonalForm& form) {
  const MatrixXd left = A * form.basis, right = form.basis * form.blocks;
  for (Index i = 0; i < A.rows(); ++i) {
    const double scale = (A.row(i).cwiseAbs() * form.basis.cwiseAbs()).norm() + form.basis.row(i).norm();
    EXPECT_LT((left.row(i) - right.row(i)).norm(), 2e-11 * scale) << "row " << i;
  }
  EXPECT_LT((form.basis * form.inverse - MatrixXd::Identity(A.rows(), A.rows())).cwiseAbs().maxCoeff(), 2e-9);
  for (std::size_t b = 0; b + 1 < form.starts.size(); ++b) {
    const Index begin = form.starts[b], size = form.starts[b + 1] - begin;
    EXPECT_TRUE(form.blocks.block(begin, 0, size, begin).isZero(0.0));
    EXPECT_TRUE(form.blocks.block(0, begin, begin, size).isZero(0.0));
  }
}

TEST(BlockDiagonalForm, ProportionalDampingNeedsNoChange) {
  const Eigen::VectorXd frequencies = Eigen::VectorXd::LinSpaced(6, 10.0, 3000.0);
  const MatrixXd A = oscillators(frequencies, MatrixXd(0.02 * frequencies.asDiagonal()));
  const auto form = block_diagonal_form(A);
  expect_form(A, form);
  EXPECT_EQ(form.largest_block(), 2);
  EXPECT_EQ(form.basis.cwiseAbs().sum(), 12.0);  // a permutation
}

TEST(BlockDiagonalForm, NonProportionalDampingGivesPairs) {
  for (const double size : {1e-3, 1.0, 30.0}) {
    const MatrixXd A = oscillators(Eigen::VectorXd::LinSpaced(8, 10.0, 3000.0), full_damping(1, 8, size));
    const auto form = block_diagonal_form(A);
    expect_form(A, form);
    EXPECT_EQ(form.largest_block(), 2) << size;
  }
}

TEST(BlockDiagonalForm, EqualFrequenciesUnderFullDamping) {
  const MatrixXd A = oscillators(Eigen::VectorXd::Constant(5, 100.0), full_damping(2, 5, 1.0));
  const auto form = block_diagonal_form(A);
  expect_form(A, form);
  EXPECT_LE(form.largest_block(), 2);
}

TEST(BlockDiagonalForm, IdenticalFiltersBehindSeveralSensors) {
  const Index modes = 4, sensors = 7;
  MatrixXd A = MatrixXd::Zero(2 * modes + 2 * sensors, 2 * modes + 2 * sensors);
  A.topLeftCorner(2 * modes, 2 * modes) =
      oscillators(Eigen::VectorXd::LinSpaced(modes, 50.0, 900.0), full_damping(3, modes, 0.5));
  for (Index s = 0; s < sensors; ++s) {
    const Index row = 2 * modes + 2 * s;
    A.block(row, row, 2, 2) << 0.0, 1.0, -600.0 * 600.0, -1.4 * 600.0;
    A.block(row + 1, 0, 1, 2 * modes) = random_matrix(4 + std::uint64_t(s), 1, 2 * modes);
  }
  const auto form = block_diagonal_form(A);
  expect_form(A, form);
  EXPECT_EQ(form.largest_block(), 2);
}

/// Two sensors with equal filters whose states are scaled differently, behind a stiff structure: rounding of the
/// structure's size must not couple what nothing couples.
TEST(BlockDiagonalForm, EqualPartsBehindAStiffOne) {
  MatrixXd A = MatrixXd::Zero(12, 12);
  A.topLeftCorner(6, 6) = oscillators(Eigen::VectorXd{{10.0, 1e4, 1e5}}, full_damping(9, 3, 3.0));
  for (Index s = 0; s < 2; ++s) {
    const Index row = 6 + 3 * s;
    A.block(row, row, 3, 3) << -700.0, 300.0, 0.0, -250.0, -600.0, 100.0, 0.0, 30.0, -500.0;
    A.block(row, 0, 3, 6) = random_matrix(11 + std::uint64_t(s), 3, 6) * 1e6;
  }
  const auto form = block_diagonal_form(A);
  expect_form(A, form);
  EXPECT_LE(form.largest_block(), 2);
  EXPECT_LT(form.basis.cwiseAbs().maxCoeff(), 2e4);  // found 1.8e3, of the size of coupling over frequency
}

/// Sensors follow the structure and do not act on it: their states have no part in the structure's coordinates. A part
/// of 1e-16 would give a structure that rests for certain a variance that is rounding.
TEST(BlockDiagonalForm, KeepsTheZerosOfItsInverse) {
  const Index modes = 4, n = 2 * modes + 4;
  MatrixXd A = MatrixXd::Zero(n, n);
  A.topLeftCorner(2 * modes, 2 * modes) =
      oscillators(Eigen::VectorXd::LinSpaced(modes, 50.0, 900.0), full_damping(5, modes, 0.5));
  for (Index s = 0; s < 2; ++s) {
    const Index row = 2 * modes + 2 * s;
    A.block(row, row, 2, 2) << 0.0, 1.0, -600.0 * 600.0, -1.4 * 600.0;
    A.block(row + 1, 0, 1, 2 * modes) = 1e6 * random_matrix(7 + std::uint64_t(s), 1, 2 * modes);
  }
  const auto form = block_diagonal_form(A);
  expect_form(A, form);
  EXPECT_TRUE(form.inverse.topRightCorner(2 * modes, 4).isZero(0.0));
  EXPECT_TRUE(form.basis.topRightCorner(2 * modes, 4).isZero(0.0));
}

TEST(BlockDiagonalForm, RigidBodyModesAndIntegratedInputsStayPairs) {
  MatrixXd A = MatrixXd::Zero(8, 8);  // two free bodies, one oscillator
  A(0, 1) = A(2, 3) = 1.0;
  A.block(4, 4, 2, 2) << 0.0, 1.0, -400.0, -2.0;
  A(6, 7) = 1.0;    // an integrated acceleration
  A(5, 6) = 400.0;  // that drives the oscillator
  const auto form = block_diagonal_form(A);
  expect_form(A, form);
  EXPECT_EQ(form.largest_block(), 2);
  A(1, 6) = 1.0;  // and one of the free bodies: a fourfold zero that no basis can separate
  const auto together = block_diagonal_form(A);
  expect_form(A, together);
  EXPECT_EQ(together.largest_block(), 4);
}

TEST(BlockDiagonalForm, CriticallyDampedCascadeStaysTogether) {
  MatrixXd A = MatrixXd::Zero(3, 3);  // three equal first-order filters in a row: one Jordan block
  A.diagonal().setConstant(-100.0);
  A(1, 0) = A(2, 1) = 100.0;
  const auto form = block_diagonal_form(A);
  expect_form(A, form);
  EXPECT_EQ(form.largest_block(), 3);
}

TEST(BlockDiagonalForm, NotANumberIsRefused) {
  MatrixXd A = MatrixXd::Identity(3, 3);
  A(1, 2) = std::nan("");
  EXPECT_THROW(block_diagonal_form(A), InvalidInput);
}

}  // namespace
}  // namespace kalfem
