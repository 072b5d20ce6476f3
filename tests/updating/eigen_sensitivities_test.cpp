// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/eigen_sensitivities.hpp"
#include "kalfem/linalg/lowest_modes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "model/fe_models.hpp"
#include "updating/affine_model.hpp"

namespace kalfem {
namespace {

using namespace test;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A model's lowest modes with what they are of.
struct Solved {
  Solved(const LinearModel& given, Index count)
      : model(given),
        shifted(factor_stiffness(model.stiffness, model.mass)),
        modes(lowest_modes(model.stiffness, model.mass, shifted, {.count = count, .tolerance = 1e-12})) {}
  [[nodiscard]] SolvedEigenproblem problem() const { return {model.stiffness, model.mass, shifted, modes}; }

  LinearModel model;
  StiffnessFactor shifted;
  LowestModes modes;
};

Solved solved(const ParameterisedModel& model, const VectorXd& parameters, Index count) {
  return {model.at(parameters).model, count};
}

VectorXd moved(VectorXd parameters, Index which, double value) {
  parameters[which] = value;
  return parameters;
}

/// The derivatives of single modes against differences, per parameter and mode; step and tolerance are relative.
void expect_derivatives(const AffineModel& model, Index computed, const std::vector<Index>& looked_at, double step,
                        double tolerance) {
  const VectorXd start = model.start();
  const Solved here = solved(model, start, computed);
  const auto derivatives = model.derivatives(start);
  for (const Index mode : looked_at) {
    const auto slopes = subspace_derivatives(here.problem(), {mode, 1}, derivatives);
    ASSERT_TRUE(slopes) << mode;
    for (Index p = 0; p < start.size(); ++p) {
      const auto at = [&](double value) {
        const LowestModes modes = solved(model, moved(start, p, value), computed).modes;
        VectorXd all(modes.vectors.rows() + 1);
        all << modes.values[mode], modes.vectors.col(mode);
        return all;
      };
      const VectorXd difference = slope_of(at, start[p], step * start[p]);
      const double rate = projected_derivative(here.modes, {mode, 1}, derivatives[std::size_t(p)])(0, 0);
      const double value_scale = here.modes.values[mode] / start[p];
      EXPECT_NEAR(rate, difference[0], tolerance * value_scale) << "mode " << mode << ", parameter " << p;
      const VectorXd shape = difference.tail(difference.size() - 1);
      const double shape_scale = here.modes.vectors.col(mode).norm() / start[p];
      EXPECT_LT(((*slopes)[std::size_t(p)].col(0) - shape).norm(), tolerance * shape_scale)
          << "mode " << mode << ", parameter " << p;
    }
  }
}

AffineModel fixed_chain() {
  return spring_model({1.0, 2.0, 1.5, 1.0, 3.0, 1.0, 2.5, 1.2}, {{-1, 0, 900.0},
                                                                 {0, 1, 700.0},
                                                                 {1, 2, 800.0},
                                                                 {2, 3, 500.0},
                                                                 {3, 4, 900.0},
                                                                 {4, 5, 650.0},
                                                                 {5, 6, 720.0},
                                                                 {6, 7, 810.0},
                                                                 {2, 5, 130.0}});
}

AffineModel free_chain() {
  return spring_model({1.0, 2.0, 1.5, 1.0, 3.0}, {{0, 1, 700.0}, {1, 2, 800.0}, {2, 3, 500.0}, {3, 4, 900.0}});
}

TEST(EigenSensitivities, ChainAgreesWithDifferences) {
  // the error of the differences: step^4 times a fifth derivative, and roundings / step
  expect_derivatives(fixed_chain(), 3, {0, 1, 2}, 5e-4, 3e-10);  // found 7e-11
  expect_derivatives(fixed_chain(), 8, {0, 4, 7}, 5e-4, 1e-9);   // found 3e-10
}

TEST(EigenSensitivities, FreeStructureAgreesWithDifferences) {
  expect_derivatives(free_chain(), 4, {1, 2, 3}, 2e-3, 1e-10);  // found 2e-11
}

TEST(EigenSensitivities, RigidModeChangesByItsMassAlone) {
  const AffineModel chain = free_chain();
  const Solved here = solved(chain, chain.start(), 3);
  SparseMatrix mass(5, 5);
  mass.insert(1, 1) = 1.0;
  const std::vector<ModelDerivative> by_mass{{{}, mass, {}, {}}};
  EXPECT_EQ(here.modes.values[0], 0.0);
  EXPECT_EQ(projected_derivative(here.modes, {0, 1}, by_mass[0])(0, 0), 0.0);
  const auto slope = subspace_derivatives(here.problem(), {0, 1}, by_mass);
  ASSERT_TRUE(slope);
  // phi = 1 / sqrt(total mass), all entries the same
  EXPECT_LT((slope->front().col(0) - VectorXd::Constant(5, -0.5 * std::pow(8.5, -1.5))).norm(),
            1e-15);  // rounding of .02
}

FiniteElementModel clamped_plate(double a, double b) {
  auto model = model_of(plate_mesh(a, b, 12, 10));
  model.properties["plate"] = ShellProperty{"steel", 0.01};
  FixedNodes edge{.name = "edge", .nodes = {}};
  for (Index j = 0; j <= 10; ++j) edge.nodes.push_back(13 * j);
  model.fixed = {edge};
  return model;
}

TEST(EigenSensitivities, PlateByLanczosAgreesWithDifferences) {
  // 0.8 x 0.5 m, one edge clamped, 792 unknowns: eight modes by Lanczos iteration. Its vectors are good to 1e-8 or so,
  // which the step of the differences divides: found 5e-9.
  const auto model = fe_affine_model(clamped_plate(0.8, 0.5), {"plate.thickness", "steel.density"});
  expect_derivatives(model, 8, {0, 1, 3}, 1e-2, 2e-8);
}

/// A beam of square section along x, clamped: all bending modes are double.
FiniteElementModel square_cantilever() {
  auto model = beam_model({1.0, 0.0, 0.0}, 10, rectangular_section(0.02, 0.02));
  model.fixed = {{.name = "root", .nodes = {0}}};
  model.springs = {{.name = "side", .from = {10, 1}, .to = {}, .stiffness = 1e3}};
  model.springs.push_back({.name = "lift", .from = {10, 2}, .to = {}, .stiffness = 1e3});
  model.springs.push_back({.name = "middle", .from = {5, 1}, .to = {}, .stiffness = 2e3});
  model.springs.push_back({.name = "middle_lift", .from = {5, 2}, .to = {}, .stiffness = 2e3});
  return model;
}

TEST(EigenSensitivities, SquareBeamHasDoubleModesWhoseSpaceMoves) {
  const auto model = fe_affine_model(square_cantilever(), {"steel.youngs_modulus", "steel.density", "side.stiffness"});
  const Solved here = solved(model, model.start(), 8);
  const auto groups = group_modes(here.modes.values, 1e-6);
  ASSERT_EQ(groups[0].size, 2);
  ASSERT_EQ(groups[1].size, 2);
  const auto slopes = subspace_derivatives(here.problem(), groups[0], model.derivatives(model.start()));
  ASSERT_TRUE(slopes);
  for (Index p = 0; p < 3; ++p) {
    // Phi Phi^T of the pair does not depend on its basis, and stays smooth while the pair splits
    const auto projector = [&](double value) {
      const MatrixXd pair = solved(model, moved(model.start(), p, value), 8).modes.vectors.leftCols(2);
      return MatrixXd(pair * pair.transpose());
    };
    const MatrixXd difference = slope_of(projector, model.start()[p], 1e-2 * model.start()[p]);
    const MatrixXd pair = here.modes.vectors.leftCols(2);
    const MatrixXd half = (*slopes)[std::size_t(p)] * pair.transpose();
    // found 3e-9: vectors of the Lanczos iteration over the step
    EXPECT_LT((half + half.transpose() - difference).norm(), 1e-8 * (pair * pair.transpose()).norm() / model.start()[p])
        << p;
  }
}

TEST(EigenSensitivities, OneSpringSplitsADoubleMode) {
  const auto model = fe_affine_model(square_cantilever(), {"side.stiffness"});
  const Solved here = solved(model, model.start(), 8);
  const auto slope = model.derivatives(model.start())[0];
  const auto split = split_eigenpairs(here.problem(), {0, 2}, slope, {});
  ASSERT_TRUE(split);
  // the mode across the spring does not feel it
  EXPECT_NEAR(split->values[0], 0.0, 1e-14 * split->values[1]);  // rounding
  const auto values = [&](double stiffness) {
    return VectorXd(solved(model, VectorXd::Constant(1, stiffness), 8).modes.values.head(2));
  };
  const double h = 1.0;  // [N/m], a thousandth; on each side the eigenvalues stand in the other order
  const VectorXd rates = (values(1e3 + h) - values(1e3)) / h;
  // a rate from one side, found 4e-6: half of h / k times the curvature of the eigenvalue
  EXPECT_NEAR(rates[1], split->values[1], 1e-5 * split->values[1]);
  // the eigenvalue, 2e4, is rounded to 3e-11 of it, as the bar is 1e5 times stiffer: found 5e-7
  EXPECT_NEAR(rates[0], 0.0, 3e-6 * split->values[1]);
}

/// K(t) = K_0 + t K_1 + t^2 K_2 and M(t) = M_0 + t M_1 + t^2 M_2, full matrices, with a triple eigenvalue at t = 0.
struct TriplePencil {
  TriplePencil() {
    std::mt19937 random(4);
    std::normal_distribution<double> normal;
    const auto matrix = [&] { return MatrixXd(MatrixXd::NullaryExpr(9, 9, [&] { return normal(random); })); };
    const auto symmetric = [&] {
      const MatrixXd any = matrix();
      return MatrixXd(any + any.transpose());
    };
    const MatrixXd shape = MatrixXd::Identity(9, 9) + 0.1 * matrix();
    VectorXd values(9);
    values << 3.0, 5.0, 5.0, 5.0, 9.0, 12.0, 17.0, 21.0, 30.0;
    K[0] = shape.transpose() * values.asDiagonal() * shape;
    M[0] = shape.transpose() * shape;
    K[1] = symmetric(), K[2] = symmetric(), M[1] = 0.05 * symmetric(), M[2] = 0.05 * symmetric();
  }
  [[nodiscard]] LinearModel at(double t) const {
    LinearModel model;
    model.stiffness = MatrixXd(K[0] + t * K[1] + t * t * K[2]).sparseView();
    model.mass = MatrixXd(M[0] + t * M[1] + t * t * M[2]).sparseView();
    return model;
  }
  MatrixXd K[3], M[3];
};

TEST(EigenSensitivities, EigenvectorsOfATripleValueFollowTheirBranches) {
  const TriplePencil pencil;
  const Solved here(pencil.at(0.0), 6);
  const ModelDerivative first{pencil.K[1].sparseView(), pencil.M[1].sparseView(), {}, {}};
  const ModelDerivative second{2.0 * pencil.K[2].sparseView(), 2.0 * pencil.M[2].sparseView(), {}, {}};
  const auto split = split_eigenpairs(here.problem(), {1, 3}, first, second);
  ASSERT_TRUE(split && split->vectors);
  const MatrixXd base = here.modes.vectors.middleCols(1, 3) * split->basis;
  // branch k is the k-th eigenvalue for t > 0 and the k-th from above for t < 0; t = 0 itself is left out
  for (Index k = 0; k < 3; ++k) {
    const auto branch = [&](double t) {
      const LowestModes modes = Solved(pencil.at(t), 6).modes;
      const Index column = t > 0.0 ? 1 + k : 3 - k;
      VectorXd all(10);
      const double sign = modes.vectors.col(column).dot(pencil.M[0] * base.col(k)) < 0.0 ? -1.0 : 1.0;
      all << modes.values[column], sign * modes.vectors.col(column);
      return all;
    };
    const VectorXd slope = slope_of(branch, 0.0, 4e-3);
    // differences of the fourth order: found 8e-11 and 2e-9
    EXPECT_NEAR(split->values[k], slope[0], 3e-10 * std::abs(slope[0]));
    EXPECT_LT((split->vectors->col(k) - slope.tail(9)).norm(), 1e-8 * slope.tail(9).norm()) << k;
  }
}

TEST(EigenSensitivities, EqualRatesHaveNoEigenvectorDerivatives) {
  const TriplePencil pencil;
  const Solved here(pencil.at(0.0), 6);
  const ModelDerivative scaling{here.model.stiffness, {}, {}, {}};  // all three move alike
  const auto split = split_eigenpairs(here.problem(), {1, 3}, scaling, {});
  ASSERT_TRUE(split);
  EXPECT_FALSE(split->vectors);
  EXPECT_LT((split->values - VectorXd::Constant(3, 5.0)).norm(), 1e-13);  // rounding
}

TEST(EigenSensitivities, AGroupThatIsCutOffHasNone) {
  const TriplePencil pencil;
  const Solved here(pencil.at(0.0), 3);  // two of the three
  const ModelDerivative first{pencil.K[1].sparseView(), {}, {}, {}};
  EXPECT_FALSE(subspace_derivatives(here.problem(), {1, 2}, {first}));
}

TEST(EigenSensitivities, NeighboursAreGroupedByTheirRelativeDistance) {
  VectorXd values(7);
  values << 0.0, 0.0, 10.0, 10.0 + 5e-6, 10.0 + 1e-5, 10.1, 2e4;
  const auto groups = group_modes(values, 1e-6);
  ASSERT_EQ(groups.size(), 4u);
  EXPECT_EQ(groups[0].size, 2);
  EXPECT_EQ(groups[1].first, 2);
  EXPECT_EQ(groups[1].size, 3);
  EXPECT_EQ(groups[3].first, 6);
  EXPECT_EQ(group_modes(values, 1e-8).size(), 6u);
}

TEST(EigenSensitivities, JointBasisDiagonalisesMatricesThatCommute) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  const MatrixXd any = MatrixXd::NullaryExpr(4, 4, [&] { return normal(random); });
  const MatrixXd Q = Eigen::HouseholderQR<MatrixXd>(any).householderQ();
  const MatrixXd A = Q * Eigen::Vector4d(1.0, 2.0, 3.0, 3.0).asDiagonal() * Q.transpose();
  const MatrixXd B = 1e9 * Q * Eigen::Vector4d(2.0, 2.0, -1.0, 5.0).asDiagonal() * Q.transpose();
  const MatrixXd basis = joint_eigenbasis({A, B});
  EXPECT_LT((basis.transpose() * basis - MatrixXd::Identity(4, 4)).norm(), 1e-14);  // rounding
  for (const MatrixXd& matrix : {A, B}) {
    MatrixXd turned = basis.transpose() * matrix * basis;
    turned.diagonal().setZero();
    EXPECT_LT(turned.norm(), 1e-14 * matrix.norm());
  }
}

TEST(EigenSensitivities, JointBasisIsTheBestCompromiseInThePlane) {
  const Eigen::Matrix2d A{{2.0, 0.3}, {0.3, 1.0}}, B{{1.0, -0.4}, {-0.4, 1.5}};
  const auto off = [&](double angle) {
    const Eigen::Matrix2d Q = Eigen::Rotation2Dd(angle).toRotationMatrix();
    return std::pow((Q.transpose() * A * Q)(0, 1) / A.norm(), 2) +
           std::pow((Q.transpose() * B * Q)(0, 1) / B.norm(), 2);
  };
  double least = off(0.0);
  for (int i = 0; i < 20000; ++i) least = std::min(least, off(i * M_PI / 20000));
  const MatrixXd basis = joint_eigenbasis({A, B});
  const double found = off(std::atan2(basis(1, 0), basis(0, 0)));
  EXPECT_LE(found, least + 1e-15);
  EXPECT_NEAR(found, least, 1e-10);  // the grid's nearest angle is 1e-5 away: found 3e-11
}

}  // namespace
}  // namespace kalfem
