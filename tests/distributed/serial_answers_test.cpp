// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "kalfem/linalg/block_lanczos.hpp"
#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/linalg/makers.hpp"
#include "kalfem/reduction/free_interface.hpp"
#include "kalfem/reduction/superelement.hpp"
#include "reduction/lattice.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// What `work` gives without the other ranks.
template <class Work>
auto on_one_rank(const Work& work) {
  auto makers = use_makers({});
  auto result = work();
  use_makers(std::move(makers));
  return result;
}

MatrixXd with_signs_of(const MatrixXd& reference, MatrixXd columns) {
  for (Index j = 0; j < columns.cols(); ++j)
    if (columns.col(j).dot(reference.col(j)) < 0.0) columns.col(j) *= -1.0;
  return columns;
}

double largest_relative_difference(const VectorXd& a, const VectorXd& b) {
  return (a - b).cwiseQuotient(b).cwiseAbs().maxCoeff();
}

const LinearModel membrane = lattice::model({.columns = 80, .rows = 45, .support = 50.0});

TEST(SerialAnswers, AreThoseOfTheModes) {
  const auto modes = [] { return lowest_modes(membrane.stiffness, membrane.mass, {.count = 30}); };
  const LowestModes serial = on_one_rank(modes), distributed = modes();
  EXPECT_LT(largest_relative_difference(distributed.values, serial.values), 2e-9);  // 1e-9 of the frequencies
  EXPECT_LT((with_signs_of(serial.vectors, distributed.vectors) - serial.vectors).norm(), 1e-6 * serial.vectors.norm());
}

/// The lowest pairs of a membrane whose rows no number of ranks divides, in a space that is soon full.
RitzPairs restarted(const LinearModel& model, Index count, MatrixXd& vectors) {
  const StiffnessFactor factor = factor_stiffness(model.stiffness, model.mass);
  BlockLanczos lanczos(factor, model.mass, 4, 40);
  lanczos.restart_at_random();
  for (int restarts = 0; restarts < 10; ++restarts) {
    while (!lanczos.full()) lanczos.step();
    if (restarts + 1 < 10) lanczos.compress(lanczos.pairs(), 2 * count);
  }
  RitzPairs pairs = lanczos.pairs();
  vectors = lanczos.vectors(pairs, count);
  return pairs;
}

TEST(SerialAnswers, AreThoseOfARestartedKrylovSpace) {
  const LinearModel odd = lattice::model({.columns = 47, .rows = 31, .support = 50.0});
  MatrixXd serial_vectors, vectors;
  const RitzPairs serial = on_one_rank([&] { return restarted(odd, 8, serial_vectors); });
  const RitzPairs distributed = restarted(odd, 8, vectors);
  EXPECT_LT(serial.residuals.head(8).maxCoeff(), 1e-9 * serial.values[7]);
  EXPECT_LT(largest_relative_difference(distributed.values.head(8), serial.values.head(8)), 1e-11);
  EXPECT_LT((with_signs_of(serial_vectors, vectors) - serial_vectors).norm(), 1e-7);
  EXPECT_LT((vectors.transpose() * odd.mass * vectors - MatrixXd::Identity(8, 8)).norm(), 1e-12);
}

TEST(SerialAnswers, AreThoseOfAFreeStructure) {
  const LinearModel free = lattice::beam(60);
  const auto modes = [&] { return lowest_modes(free.stiffness, free.mass, {.count = 12}); };
  const LowestModes serial = on_one_rank(modes), distributed = modes();
  EXPECT_EQ(distributed.values.head(2), VectorXd::Zero(2));
  EXPECT_LT(largest_relative_difference(distributed.values.tail(10), serial.values.tail(10)), 2e-9);
}

/// A superelement on all ranks against the one of rank 0 alone, with the signs of its shapes.
template <class Reduce>
void expect_serial_superelement(const Reduce& reduce) {
  const Superelement serial = on_one_rank(reduce), distributed = reduce();
  ASSERT_EQ(distributed.basis.cols(), serial.basis.cols());
  const MatrixXd basis = with_signs_of(serial.basis, distributed.basis);
  EXPECT_LT((basis - serial.basis).norm(), 1e-8 * serial.basis.norm());
  const auto in_serial_signs = [&](const SparseMatrix& matrix) -> MatrixXd {
    const VectorXd signs = basis.cwiseProduct(distributed.basis).colwise().sum().cwiseSign();
    return signs.asDiagonal() * MatrixXd(matrix) * signs.asDiagonal();
  };
  for (const auto matrix : {&LinearModel::stiffness, &LinearModel::mass, &LinearModel::damping}) {
    const MatrixXd expected(serial.model.*matrix);
    EXPECT_LT((in_serial_signs(distributed.model.*matrix) - expected).norm(), 1e-8 * expected.norm());
  }
  EXPECT_EQ(distributed.error_indicators.order, serial.error_indicators.order);
}

const auto boundary = lattice::edge(79, 45);

TEST(SerialAnswers, AreThoseOfTheSuperelement) {
  expect_serial_superelement([] { return craig_bampton(membrane, boundary, {.modes = {.count = 25}}); });
}

TEST(SerialAnswers, AreThoseOfTheSuperelementWithAugmentationVectors) {
  expect_serial_superelement(
      [] { return craig_bampton(membrane, boundary, {.modes = {.count = 25}, .augmentation_vectors = true}); });
}

TEST(SerialAnswers, AreThoseOfTheFreeInterfaceSuperelement) {
  for (const auto kind : {FreeInterfaceKind::rubin, FreeInterfaceKind::macneal})
    expect_serial_superelement(
        [kind] { return free_interface(membrane, lattice::edge(79, 5), {.kind = kind, .modes = {.count = 25}}); });
}

}  // namespace
}  // namespace kalfem
