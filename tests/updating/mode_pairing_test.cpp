// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/mode_pairing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The best sum of positive gains by trying every choice.
double best_sum(const MatrixXd& gains, Index row = 0, unsigned used = 0) {
  if (row == gains.rows()) return 0.0;
  double best = best_sum(gains, row + 1, used);
  for (Index j = 0; j < gains.cols(); ++j)
    if (!(used >> j & 1u) && gains(row, j) > 0.0)
      best = std::max(best, gains(row, j) + best_sum(gains, row + 1, used | 1u << j));
  return best;
}

TEST(ModePairing, AssignmentIsTheBestOfAll) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-0.6, 1.0);
  for (int trial = 0; trial < 300; ++trial) {
    const Index rows = 1 + trial % 6, columns = trial % 7;
    const MatrixXd gains = MatrixXd::NullaryExpr(rows, columns, [&] { return uniform(random); });
    const auto assignment = best_assignment(gains);
    ASSERT_EQ(assignment.size(), std::size_t(rows));
    double sum = 0.0;
    std::vector<bool> used(std::size_t(columns), false);
    for (Index i = 0; i < rows; ++i)
      if (const auto j = assignment[std::size_t(i)]) {
        EXPECT_GT(gains(i, *j), 0.0);
        EXPECT_FALSE(used[std::size_t(*j)]);
        used[std::size_t(*j)] = true;
        sum += gains(i, *j);
      }
    EXPECT_NEAR(sum, best_sum(gains), 1e-14);  // rounding of a sum of six
  }
}

TEST(ModePairing, MacKnowsNeitherSignNorScale) {
  const MatrixXd one{{1.0, 2.0, 0.0}, {2.0, -1.0, 0.0}, {0.0, 1.0, 0.0}};
  const MatrixXd other{{-3.0, 1.0}, {-6.0, 1.0}, {0.0, 1.0}};
  const MatrixXd mac = mac_matrix(one, other);
  // rounding
  EXPECT_NEAR(mac(0, 0), 1.0, 1e-15);
  EXPECT_NEAR(mac(1, 0), 0.0, 1e-15);
  EXPECT_NEAR(mac(0, 1), 9.0 / 15.0, 1e-15);
  EXPECT_NEAR(mac(1, 1), 4.0 / 18.0, 1e-15);
  EXPECT_EQ(mac(2, 0), 0.0);  // no motion
}

TEST(ModePairing, MassWeightMakesModesOrthogonal) {
  const Eigen::Matrix2d K{{3.0, -1.0}, {-1.0, 1.0}}, M{{5.0, 0.0}, {0.0, 0.4}};
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> pairs(K, M);
  const SparseMatrix mass = MatrixXd(M).sparseView();
  EXPECT_LT((mac_matrix(pairs.eigenvectors(), pairs.eigenvectors(), &mass) - MatrixXd::Identity(2, 2)).norm(), 1e-14);
  EXPECT_GT(mac_matrix(pairs.eigenvectors(), pairs.eigenvectors())(0, 1), 0.01);
}

TEST(ModePairing, FitInOneShapeIsTheModalScaleFactor) {
  const VectorXd shape = Eigen::Vector3d(1.0, 2.0, 2.0), target = Eigen::Vector3d(-2.0, -4.0, -3.0);
  const auto fit = fit_in_subspace(shape.transpose() * shape, shape.transpose() * target, target.squaredNorm());
  // rounding
  EXPECT_NEAR(fit.coefficients[0], -16.0 / 9.0, 1e-15);
  EXPECT_NEAR(fit.mac, mac_matrix(shape, target)(0, 0), 1e-15);
  const MatrixXd plane{{1.0, 0.0}, {0.0, 1.0}, {0.0, 0.0}};
  const auto combined = fit_in_subspace(plane.transpose() * plane, plane.transpose() * target, target.squaredNorm());
  EXPECT_NEAR(combined.mac, 20.0 / 29.0, 1e-15);
}

/// Shapes of a string with `points` points.
MatrixXd sines(Index points, Index modes) {
  return MatrixXd::NullaryExpr(
      points, modes, [&](Index i, Index j) { return std::sin((i + 1.0) * (j + 1.0) * M_PI / (points + 1.0)); });
}

TEST(ModePairing, CrossedMissingAndSpuriousModes) {
  const MatrixXd model = sines(6, 5);
  VectorXd frequencies(5);
  frequencies << 10.0, 21.0, 20.0, 40.0, 50.0;
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  MatrixXd measured(6, 4);  // the second and third crossed, with other signs and noise; the first missing; a local mode
  measured << -model.col(2), 0.1 * model.col(1), VectorXd::Unit(6, 0), model.col(3);
  for (Index j : {0, 1, 3})
    measured.col(j) += 0.05 * measured.col(j).norm() * VectorXd::NullaryExpr(6, [&] { return normal(random); });
  VectorXd seen(4);
  seen << 20.4, 20.6, 33.0, 43.0;
  const auto pairs = pair_modes(mac_matrix(measured, model), seen, frequencies, {.least_mac = 0.6});
  EXPECT_EQ(pairs[0].model, 2);
  EXPECT_EQ(pairs[1].model, 1);
  EXPECT_FALSE(pairs[2].model);
  EXPECT_EQ(pairs[3].model, 3);
  EXPECT_GT(pairs[0].mac, 0.9);
  // differences of frequencies to rounding
  EXPECT_NEAR(pairs[3].frequency_difference, 40.0 / 43.0 - 1.0, 1e-15);
  EXPECT_LT(pairs[2].mac, 0.6);  // the best there is, and the nearest frequency
  EXPECT_NEAR(pairs[2].frequency_difference, 40.0 / 33.0 - 1.0, 1e-15);
}

TEST(ModePairing, FrequencyDecidesBetweenShapesThatLookAlike) {
  // at too few points the fourth mode looks like the first
  MatrixXd mac = MatrixXd::Constant(1, 4, 0.1);
  mac(0, 0) = 0.97, mac(0, 3) = 0.99;
  VectorXd model(4);
  model << 10.0, 20.0, 30.0, 40.0;
  EXPECT_EQ(pair_modes(mac, VectorXd::Constant(1, 11.0), model)[0].model, 0);
  EXPECT_EQ(pair_modes(mac, VectorXd::Constant(1, 37.0), model)[0].model, 3);
  EXPECT_EQ(pair_modes(mac, VectorXd::Constant(1, 11.0), model, {.frequency_weight = 0.0})[0].model, 3);
}

TEST(ModePairing, TotalAgreementCounts) {
  // the first measured mode gives up its best partner, because the second has no other
  const MatrixXd mac{{0.95, 0.9}, {0.9, 0.1}};
  const VectorXd same = VectorXd::Constant(2, 10.0);
  const auto pairs = pair_modes(mac, same, same);
  EXPECT_EQ(pairs[0].model, 1);
  EXPECT_EQ(pairs[1].model, 0);
}

TEST(ModePairing, PointsAreDegreesOfFreedomNamedPointsOrSums) {
  LinearModel model;
  model.dofs = {"a", "b", "c"};
  model.points = {{"middle", {{"a", 0.5}, {"b", 0.5}}}};
  const MatrixXd rows = point_rows(model, {{{"c", 1.0}}, {{"middle", -2.0}}, {{"a", 1.0}, {"middle", 1.0}}});
  const MatrixXd expected{{0.0, 0.0, 1.0}, {-1.0, -1.0, 0.0}, {1.5, 0.5, 0.0}};
  EXPECT_EQ(rows, expected);
  try {
    point_rows(model, {{{"d", 1.0}}, {{"midle", 1.0}}});
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_EQ(error.issues().size(), 2u);
    EXPECT_NE(std::string(error.what()).find("'middle'"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace kalfem
