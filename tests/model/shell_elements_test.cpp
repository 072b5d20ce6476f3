// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numeric>

#include "kalfem/model/assembly/assembly.hpp"
#include "kalfem/model/elements/shell.hpp"
#include "model/element_helpers.hpp"
#include "shell_models.hpp"

namespace kalfem {
namespace {

using test::points;
using test::scaled_difference;
using test::Shape;
using test::some_turn;
using test::turned;

constexpr double nu = 0.3;

/// An element by its corners: a quadrilateral of four, a triangle of three.
ElementMatrices shell(const Eigen::Matrix3Xd& corners, double thickness, MassKind kind = MassKind::consistent,
                      double poissons_ratio = nu) {
  const ShellProperty property{.material = "", .thickness = thickness};
  if (corners.cols() == 4) return shell4(corners, poissons_ratio, property, kind);
  return shell3(corners, poissons_ratio, property, kind);
}

/// Sum of the terms for E = 1, rho = 1.
Eigen::MatrixXd sum(const std::vector<ElementTerm>& terms, double thickness) {
  Eigen::MatrixXd total = Eigen::MatrixXd::Zero(terms.front().matrix.rows(), terms.front().matrix.cols());
  for (const auto& term : terms) total += std::pow(thickness, term.powers.thickness) * term.matrix;
  return total;
}

std::vector<Shape> shapes() {
  const auto square = points({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
  const auto skewed = points({{0, 0, 0}, {2, 0, 0}, {3, 1, 0}, {1, 1, 0}});
  const auto irregular = points({{0, 0, 0}, {1.3, 0.1, 0}, {0.9, 1.2, 0}, {-0.2, 0.7, 0}});
  const auto warped = points({{0, 0, 0.1}, {1.3, 0.1, -0.1}, {0.9, 1.2, 0.15}, {-0.2, 0.7, -0.1}});
  const auto twisted = points({{0, 0, 0.3}, {1, 0, -0.3}, {1, 1, 0.3}, {0, 1, -0.3}});
  const auto right = points({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  const auto obtuse = points({{0, 0, 0}, {2, 0, 0}, {-0.7, 0.6, 0}});
  const Eigen::Vector3d far(3.0, -7.0, 11.0);
  return {{"square", square},
          {"skewed", skewed},
          {"irregular", irregular},
          {"irregular_tilted", (some_turn() * irregular).colwise() + far},
          {"quad_long", Eigen::Vector3d(100.0, 1.0, 1.0).asDiagonal() * irregular},
          {"quad_tiny", 1e-6 * irregular},
          {"quad_huge", 1e4 * irregular},
          {"warped", warped, false},
          {"warped_tiny", 1e-6 * warped, false},
          {"twisted", (some_turn() * twisted).colwise() + far, false},
          {"right", right},
          {"equilateral", points({{0, 0, 0}, {1, 0, 0}, {0.5, std::sqrt(0.75), 0}})},
          {"obtuse", obtuse},
          {"obtuse_tilted", (some_turn() * obtuse).colwise() + far},
          {"triangle_long", Eigen::Vector3d(50.0, 1.0, 1.0).asDiagonal() * obtuse},
          {"triangle_tiny", 1e-6 * obtuse},
          {"triangle_huge", 1e4 * obtuse}};
}

/// Displacements and rotations of the corners under u(x), theta(x).
template <typename Field>
Eigen::VectorXd nodal(const Eigen::Matrix3Xd& corners, const Field& field) {
  Eigen::VectorXd values(6 * corners.cols());
  for (Eigen::Index i = 0; i < corners.cols(); ++i) values.segment<6>(6 * i) = field(Eigen::Vector3d(corners.col(i)));
  return values;
}

Eigen::Matrix<double, 6, 1> both(const Eigen::Vector3d& displacement, const Eigen::Vector3d& rotation) {
  return (Eigen::Matrix<double, 6, 1>() << displacement, rotation).finished();
}

class ShellLaws : public testing::TestWithParam<Shape> {
protected:
  const Shape& shape() const { return GetParam(); }
  Eigen::MatrixXd stiffness() const {
    return sum(shell(shape().corners, shape().thickness()).stiffness, shape().thickness());
  }
  bool is_long() const { return std::string(shape().name).ends_with("_long"); }
  /// Of a stiffness's entries against its diagonal ones. Found 6e-15, and 3e-12 of the quadrilateral that is a hundred
  /// times as long as wide.
  double rounding() const { return is_long() ? 1e-11 : 6e-14; }
};

TEST_P(ShellLaws, EveryTermIsSymmetric) {
  const auto element = shell(shape().corners, shape().thickness());
  for (const auto& terms : {element.stiffness, element.mass})
    for (const auto& term : terms) EXPECT_TRUE(term.matrix == term.matrix.transpose());
}

TEST_P(ShellLaws, SixMotionsAndNoMoreAreFree) {
  const Eigen::MatrixXd k = stiffness();
  const Eigen::VectorXd scale = k.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::VectorXd values =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scale.asDiagonal() * k * scale.asDiagonal()).eigenvalues();
  // Rounding of the coordinates away from the origin; the softest mode of the triangle, its turn about the normal
  // against the two other rotations, is meant to be soft (1e-8).
  EXPECT_LT(std::abs(values[5]), 3e-14) << values.transpose();
  EXPECT_GT(values[6], 1e-9) << values.transpose();
}

TEST_P(ShellLaws, RigidMotionMeetsNoForce) {
  const Eigen::MatrixXd k = stiffness();
  const Eigen::VectorXd scale = k.diagonal().cwiseSqrt();
  const Eigen::Vector3d centre = shape().corners.rowwise().mean();
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d e = Eigen::Vector3d::Unit(axis);
    const Eigen::VectorXd shift = nodal(shape().corners, [&](const auto&) { return both(e, Eigen::Vector3d::Zero()); });
    const Eigen::VectorXd turn =
        nodal(shape().corners, [&](const Eigen::Vector3d& x) { return both(e.cross(x - centre), e); });
    for (const auto& motion : {shift, turn}) {
      // Against the forces of the single displacements that make up the motion.
      EXPECT_LT((scale.cwiseInverse().asDiagonal() * k * motion).norm(),
                (is_long() ? 1.2e-13 : 4e-14) * (scale.asDiagonal() * motion).norm())
          << "axis " << axis;
    }
  }
}

TEST_P(ShellLaws, MatricesTurnWithTheElement) {
  const auto element = shell(shape().corners, shape().thickness());
  const auto other =
      shell((some_turn() * shape().corners).colwise() + Eigen::Vector3d(1, 2, 3) * shape().size(), shape().thickness());
  const double t = shape().thickness();
  EXPECT_LT(scaled_difference(sum(other.stiffness, t), turned(sum(element.stiffness, t), some_turn())), rounding());
  EXPECT_LT(scaled_difference(sum(other.mass, t), turned(sum(element.mass, t), some_turn())),
            is_long() ? 2e-13 : 3e-14);
}

TEST_P(ShellLaws, FirstCornerIsOfNoAccount) {
  const Eigen::Index n = shape().corners.cols();
  const double t = shape().thickness();
  const auto element = shell(shape().corners, t);
  Eigen::Matrix3Xd shifted(3, n);
  Eigen::VectorXi order(6 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    shifted.col(i) = shape().corners.col((i + 1) % n);
    for (int k = 0; k < 6; ++k) order[6 * i + k] = static_cast<int>(6 * ((i + 1) % n) + k);
  }
  const auto other = shell(shifted, t);
  EXPECT_LT(scaled_difference(sum(other.stiffness, t), sum(element.stiffness, t)(order, order)), rounding());
  EXPECT_LT(scaled_difference(sum(other.mass, t), sum(element.mass, t)(order, order)), 2e-14);  // rounding
}

TEST_P(ShellLaws, SideUpIsOfNoAccount) {
  // Corners in the other sense turn the normal over.
  const Eigen::Index n = shape().corners.cols();
  const double t = shape().thickness();
  Eigen::VectorXi order(6 * n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (int k = 0; k < 6; ++k) order[6 * i + k] = static_cast<int>(6 * (n - 1 - i) + k);
  const auto other = shell(shape().corners.rowwise().reverse(), t);
  EXPECT_LT(scaled_difference(sum(other.stiffness, t), stiffness()(order, order)), rounding());
}

TEST_P(ShellLaws, MassIsPositiveAndThatOfTheArea) {
  const double t = shape().thickness();
  const Eigen::Index n = shape().corners.cols();
  const Eigen::Vector3d one = shape().corners.col(2) - shape().corners.col(0);
  const Eigen::Vector3d other = shape().corners.col(n - 1) - shape().corners.col(1);
  const double area = 0.5 * one.cross(other).norm();
  for (const auto kind : {MassKind::consistent, MassKind::lumped}) {
    const Eigen::MatrixXd mass = sum(shell(shape().corners, t, kind).mass, t);
    const Eigen::VectorXd scale = mass.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::VectorXd values =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scale.asDiagonal() * mass * scale.asDiagonal()).eigenvalues();
    EXPECT_GT(values[0], 0.01);  // an even consistent mass has (1/3)^2 in a quadrilateral
    EXPECT_TRUE(kind == MassKind::consistent || mass.isDiagonal(0.0));
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::VectorXd shift = nodal(
          shape().corners, [&](const auto&) { return both(Eigen::Vector3d::Unit(axis), Eigen::Vector3d::Zero()); });
      const double total = shift.dot(mass * shift);
      if (shape().flat) {
        EXPECT_NEAR(total, t * area, 1e-14 * t * area);  // rounding
      } else {  // a warped surface is larger than its projection along the normal of its diagonals
        EXPECT_GT(total, t * area);
        EXPECT_LT(total, 1.5 * t * area);
      }
    }
  }
}

TEST_P(ShellLaws, TermsHoldForAnotherThickness) {
  const double t = shape().thickness(), other = 1.7 * t;
  const auto element = shell(shape().corners, t), thicker = shell(shape().corners, other);
  EXPECT_LT(scaled_difference(sum(element.mass, other), sum(thicker.mass, other)), 2e-15);  // rounding
  if (shape().corners.cols() == 4)
    EXPECT_LT(scaled_difference(sum(element.stiffness, other), sum(thicker.stiffness, other)), 2e-15);
  else  // the bending of the triangle depends on the thickness through its condensed node
    EXPECT_LT(scaled_difference(element.stiffness[0].matrix + Eigen::MatrixXd::Identity(18, 18),
                                thicker.stiffness[0].matrix + Eigen::MatrixXd::Identity(18, 18)),
              2e-15);
  for (const auto& term : element.stiffness) EXPECT_EQ(term.powers.youngs_modulus, 1);
  for (const auto& term : element.mass) EXPECT_EQ(term.powers.density, 1);
}

INSTANTIATE_TEST_SUITE_P(Shapes, ShellLaws, testing::ValuesIn(shapes()),
                         [](const auto& one) { return std::string(one.param.name); });

// Energies of given states ------------------------------------------------------------------------------------------

TEST(Shell4, ConstantTransverseShearHasItsEnergy) {
  // w = g . x, no rotation: 1/2 (5/6) G t g^2 per area, on any flat quadrilateral. Rounding.
  for (const auto& shape : shapes()) {
    if (shape.corners.cols() != 4 || !shape.flat || std::string(shape.name) == "irregular_tilted") continue;
    const auto element = shell(shape.corners, shape.thickness());
    const double area = element.mass.front().matrix(Eigen::seqN(0, 4, 6), Eigen::seqN(0, 4, 6)).sum();
    const Eigen::VectorXd motion = nodal(shape.corners, [&](const Eigen::Vector3d& x) {
      return both({0.0, 0.0, 0.4 * x.x() - 0.3 * x.y()}, Eigen::Vector3d::Zero());
    });
    const double expected = 0.25 * 5.0 / 6.0 * shape.thickness() * area / (2.0 * (1.0 + nu));
    // rounding
    EXPECT_NEAR(motion.dot(sum(element.stiffness, shape.thickness()) * motion), expected, 5e-13 * expected) << shape;
  }
}

TEST(Shell3, ConstantTransverseShearOfAThickTriangleHasItsEnergy) {
  // So thick that the fourth node's rotation, which the shear would turn, is held by the bending stiffness: (h/t)^2.
  const auto corners = points({{0, 0, 0}, {2, 0.1, 0}, {-0.7, 0.6, 0}});
  const double t = 1e5, area = 0.5 * (2.0 * 0.6 + 0.7 * 0.1);
  const Eigen::VectorXd motion = nodal(corners, [&](const Eigen::Vector3d& x) {
    return both({0.0, 0.0, 0.4 * x.x() - 0.3 * x.y()}, Eigen::Vector3d::Zero());
  });
  const double expected = 0.25 * 5.0 / 6.0 * t * area / (2.0 * (1.0 + nu));
  EXPECT_NEAR(motion.dot(sum(shell(corners, t).stiffness, t) * motion), expected, 7e-11 * expected);  // found 6e-12
}

/// Energy of a rectangle a x 1 bent in its plane, u = -x y, v = x^2 / 2 + nu y^2 / 2, theta_z = x, per E t, against
/// that of a beam, a / 24.
double bending_ratio(const std::vector<std::vector<int>>& cells, double a, double poissons_ratio) {
  const auto corners = points({{0, 0, 0}, {a, 0, 0}, {a, 1, 0}, {0, 1, 0}});
  double energy = 0.0;
  for (const auto& cell : cells) {
    const Eigen::Matrix3Xd own = corners(Eigen::all, cell);
    const Eigen::VectorXd motion = nodal(own, [&](const Eigen::Vector3d& place) {
      const double x = place.x() - 0.5 * a, y = place.y() - 0.5;
      return both({-x * y, 0.5 * x * x + 0.5 * poissons_ratio * y * y, 0.0}, {0.0, 0.0, x});
    });
    const auto element = shell(own, 1e-3, MassKind::consistent, poissons_ratio);
    energy += 0.5 * motion.dot(element.stiffness.front().matrix * motion);
  }
  return energy / (a / 24.0);
}

TEST(Shell4, OneLayerBendsInItsPlaneLikeABeam) {
  for (const double aspect : {0.5, 1.0, 10.0})
    // rounding
    for (const double ratio : {0.0, 0.3, 0.49})
      EXPECT_NEAR(bending_ratio({{0, 1, 2, 3}}, aspect, ratio), 1.0, aspect > 1.0 ? 1e-11 : 3e-15)
          << aspect << " " << ratio;
}

TEST(Shell3, OneLayerBendsInItsPlaneLikeABeam) {
  // The triangle's optimality, of Poisson's ratios up to where its floor of 1/100 begins.
  for (const double aspect : {0.5, 1.0, 10.0})
    // rounding
    for (const double ratio : {0.0, 0.3, 0.49})
      EXPECT_NEAR(bending_ratio({{0, 1, 2}, {0, 2, 3}}, aspect, ratio), 1.0, aspect > 1.0 ? 5e-12 : 3e-15)
          << aspect << " " << ratio;
}

/// Least energy (twice) over all motions with these deflections z of the corners.
double least_energy(const Eigen::MatrixXd& stiffness, const Eigen::VectorXd& deflections) {
  std::vector<int> held, free;
  for (int i = 0; i < 24; ++i) (i % 6 == 2 ? held : free).push_back(i);
  const Eigen::MatrixXd inner = stiffness(free, free), coupled = stiffness(free, held), own = stiffness(held, held);
  const Eigen::VectorXd load = coupled * deflections;
  const Eigen::VectorXd follow = inner.completeOrthogonalDecomposition().solve(load);
  return deflections.dot(own * deflections) - load.dot(follow);
}

TEST(Shell4, WarpLeavesTwistWithoutMembraneStrain) {
  // Saddle z = c x y that twists further: its sides can keep their lengths, so that it is about as soft as a flat plate
  // in twist. The interpolated membrane strain would make it (c / t)^2 = 400 times stiffer.
  const double c = 0.2, t = 0.01;
  const auto corners = points({{-1, -1, c}, {1, -1, -c}, {1, 1, c}, {-1, 1, -c}});
  const Eigen::Matrix3Xd flat = Eigen::Vector3d(1, 1, 0).asDiagonal() * corners;
  const Eigen::VectorXd deflections = Eigen::Vector4d(1, -1, 1, -1);
  const double ratio = least_energy(sum(shell(corners, t).stiffness, t), deflections) /
                       least_energy(sum(shell(flat, t).stiffness, t), deflections);
  EXPECT_GT(ratio, 0.5);
  EXPECT_LT(ratio, 1.5);
}

// Patch tests ---------------------------------------------------------------------------------------------------------

/// Nodal values of a field in the axes of the patch.
using Field = std::function<Eigen::Matrix<double, 6, 1>(double x, double y)>;

struct PatchState {
  const char* name;
  Field field;
};

std::vector<PatchState> patch_states() {
  return {{"stretch_x",
           [](double x, double) {
             return both({x, 0, 0}, {0, 0, 0});
           }},
          {"stretch_y",
           [](double, double y) {
             return both({0, y, 0}, {0, 0, 0});
           }},
          {"shear_with_turn",
           [](double, double y) {
             return both({y, 0, 0}, {0, 0, -0.5});
           }},
          {"bend_x",
           [](double x, double) {
             return both({0, 0, 0.5 * x * x}, {0, -x, 0});
           }},
          {"bend_y",
           [](double, double y) {
             return both({0, 0, 0.5 * y * y}, {y, 0, 0});
           }},
          {"twist", [](double x, double y) {
             return both({0, 0, x * y}, {x, -y, 0});
           }}};
}

struct PatchCase {
  CellShape shape;
  double thickness;
};

class ShellPatch : public testing::TestWithParam<PatchCase> {};

TEST_P(ShellPatch, ConstantStrainsComeOutExactly) {
  const auto [shape, thickness] = GetParam();
  const Eigen::Matrix3d turn = some_turn();
  const double a = 2.4, b = 1.2;
  const test::ShellProblem patch(
      {4, 3, shape, true},
      [&](double u, double v) -> Eigen::Vector3d { return turn * Eigen::Vector3d(a * u, b * v, 0.0); },
      {.youngs_modulus = 1e6, .poissons_ratio = nu, .density = 1.0}, thickness);
  const auto model = assemble(patch.model);
  const Eigen::MatrixXd k(evaluate(model.stiffness, model.parameters));
  ASSERT_EQ(k.rows(), 6 * patch.grid.mesh.node_count());
  std::vector<Eigen::Index> inner, outer;
  for (int j = 0; j <= 3; ++j)
    for (int i = 0; i <= 4; ++i)
      for (int d = 0; d < 6; ++d)
        (i > 0 && i < 4 && j > 0 && j < 3 ? inner : outer).push_back(6 * patch.grid.node(i, j) + d);
  const double nu_factor = 1.0 - nu * nu, area = a * b, e = 1e6;
  const double membrane = e * thickness / nu_factor, bending = e * std::pow(thickness, 3) / 12.0 / nu_factor;
  const std::vector<double> energies = {membrane, membrane, membrane * (1.0 - nu) / 2.0,
                                        bending,  bending,  bending * 2.0 * (1.0 - nu)};
  const auto states = patch_states();
  for (std::size_t s = 0; s < states.size(); ++s) {
    Eigen::VectorXd exact(k.rows());
    for (Eigen::Index n = 0; n < patch.grid.mesh.node_count(); ++n) {
      const Eigen::Vector3d local = turn.transpose() * patch.grid.mesh.nodes.col(n);
      const auto values = states[s].field(local.x(), local.y());
      exact.segment<6>(6 * n) = both(turn * values.head<3>(), turn * values.tail<3>());
    }
    const Eigen::VectorXd force = -k(inner, outer) * exact(outer);
    const Eigen::VectorXd found = Eigen::MatrixXd(k(inner, inner)).ldlt().solve(force);
    // Rounding times the condition, (h/t)^2 ~ 1e4 at the thin end: found 7e-12 and 1.7e-10.
    EXPECT_LT((found - exact(inner)).cwiseAbs().maxCoeff(), 7e-11) << states[s].name;
    EXPECT_NEAR(exact.dot(k * exact), energies[s] * area, 1e-9 * energies[s] * area) << states[s].name;
  }
}

INSTANTIATE_TEST_SUITE_P(Cells, ShellPatch,
                         testing::Values(PatchCase{CellShape::quadrilateral4, 0.2},
                                         PatchCase{CellShape::quadrilateral4, 0.005},
                                         PatchCase{CellShape::triangle3, 0.2}, PatchCase{CellShape::triangle3, 0.005}),
                         [](const auto& one) {
                           return std::string(one.param.shape == CellShape::triangle3 ? "triangles"
                                                                                      : "quadrilaterals") +
                                  (one.param.thickness > 0.1 ? "_thick" : "_thin");
                         });

// Shapes that cannot be integrated --------------------------------------------------------------------------------

std::string problem_of(const Eigen::Matrix3Xd& corners) {
  try {
    shell(corners, 0.1);
  } catch (const ElementShapeError& error) {
    return error.what();
  }
  return "";
}

TEST(ShellShapes, WhatCannotBeIntegratedIsNamed) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto expect = [](const Eigen::Matrix3Xd& corners, const std::string& part) {
    EXPECT_NE(problem_of(corners).find(part), std::string::npos) << part << ": " << problem_of(corners);
  };
  expect(points({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}), "zero");          // bow tie, symmetric
  expect(points({{0, 0, 0}, {1, 0, 0}, {0.2, 1, 0}, {1.5, 0.6, 0}}), "corner");  // bow tie
  expect(points({{0, 0, 0}, {1, 0, 0}, {0.2, 0.2, 0}, {0, 1, 0}}), "corner 3");  // concave
  expect(points({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}}), "corner 2");      // a triangle
  expect(points({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}), "area is zero");
  expect(points({{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {0, 1, 0}}), "corners 2 and 3 coincide");
  expect(points({{0, 0, 1.5}, {1, 0, -1.5}, {1, 1, 1.5}, {0, 1, -1.5}}), "warped");
  expect(points({{0, 0, 0}, {1, nan, 0}, {1, 1, 0}, {0, 1, 0}}), "not a finite number");
  expect(points({{0, 0, 0}, {1, 1, 1}, {3, 3, 3}}), "area is zero");
  expect(points({{5, 0, 0}, {1, 1, 1}, {5, 0, 0}}), "corners 1 and 3 coincide");
  expect(points({{0, 0, 0}, {1, nan, 0}, {0, 1, 0}}), "not a finite number");
  for (const auto& shape : shapes()) EXPECT_EQ(problem_of(shape.corners), "") << shape;
}

}  // namespace
}  // namespace kalfem
