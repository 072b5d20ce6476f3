// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/elements/shell.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/model/assembly/rigid_body.hpp"
#include "kalfem/model/mesh/laminate_theory.hpp"
#include "model/element_helpers.hpp"
#include "shell_models.hpp"

// Shells of any cross-section and their offsets: the laws of every shell element, lamination theory by hand, and simply
// supported laminated plates in closed form. [Jon99]: Jones, Mechanics of Composite Materials. [Red04]: Reddy,
// Mechanics of Laminated Composite Plates and Shells.

namespace kalfem {
namespace {

using test::points;
using test::scaled_difference;
using test::Shape;
using test::some_turn;
using test::turned;

using std::numbers::pi;

/// A graphite-epoxy of many published examples, per unit E2: E1 = 25, G12 = G13 = 0.5, G23 = 0.2, nu12 = 0.25 [Red04].
const OrthotropicSheet graphite{.youngs_modulus_1 = 25e9,
                                .youngs_modulus_2 = 1e9,
                                .poissons_ratio_12 = 0.25,
                                .shear_modulus_12 = 0.5e9,
                                .shear_modulus_13 = 0.5e9,
                                .shear_modulus_23 = 0.2e9,
                                .density = 1600.0};

std::vector<Ply> stack(const std::vector<double>& degrees, double thickness, const OrthotropicSheet& sheet = graphite) {
  std::vector<Ply> plies;
  for (const double angle : degrees)
    plies.push_back({sheet, thickness / static_cast<double>(degrees.size()), angle * pi / 180.0});
  return plies;
}

/// Of no symmetry at all.
LaminateProperty any_laminate(double thickness) { return laminated(stack({20, -50, 75}, thickness), -0.5 * thickness); }

std::vector<Shape> shapes() {
  const auto irregular = points({{0, 0, 0}, {1.3, 0.1, 0}, {0.9, 1.2, 0}, {-0.2, 0.7, 0}});
  const auto warped = points({{0, 0, 0.1}, {1.3, 0.1, -0.1}, {0.9, 1.2, 0.15}, {-0.2, 0.7, -0.1}});
  const auto obtuse = points({{0, 0, 0}, {2, 0, 0}, {-0.7, 0.6, 0}});
  return {{"square", points({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}})},
          {"irregular_tilted", some_turn() * irregular},
          {"warped", warped, false},
          {"right", points({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}})},
          {"obtuse_tilted", some_turn() * obtuse}};
}

ElementMatrices isotropic(const Eigen::Matrix3Xd& corners, double nu, const ShellProperty& property, MassKind kind) {
  return corners.cols() == 4 ? shell4(corners, nu, property, kind) : shell3(corners, nu, property, kind);
}

/// Sum of the terms at these values.
Eigen::MatrixXd sum(const std::vector<ElementTerm>& terms, double youngs_modulus, double density, double thickness) {
  Eigen::MatrixXd total = Eigen::MatrixXd::Zero(terms.front().matrix.rows(), terms.front().matrix.cols());
  for (const auto& term : terms)
    total += std::pow(youngs_modulus, term.powers.youngs_modulus) * std::pow(density, term.powers.density) *
             std::pow(thickness, term.powers.thickness) * term.matrix;
  return total;
}

class LaminateLaws : public testing::TestWithParam<Shape> {
protected:
  const Eigen::Matrix3Xd& corners() const { return GetParam().corners; }
  Eigen::Vector3d direction() const {
    return corners().col(1) - 1.4 * corners().col(0) + 0.4 * corners().rowwise().mean();
  }
};

TEST_P(LaminateLaws, IsotropicLaminateIsTheIsotropicShell) {
  const double e = 7e10, nu = 0.31, rho = 2700.0, t = 0.06;
  const IsotropicMaterial material{e, nu, rho};
  const auto layers = std::vector<Ply>{{sheet_of(material), 0.4 * t, 0.3}, {sheet_of(material), 0.6 * t, -1.0}};
  for (const double offset : {0.0, 0.04, -0.1})
    for (const auto kind : {MassKind::consistent, MassKind::lumped}) {
      const ShellProperty plain{.material = "", .thickness = t, .offset = offset, .nonstructural_mass = 11.0};
      auto general = laminated(layers, offset - 0.5 * t);
      EXPECT_NEAR(general.offset, offset, 1e-16);  // rounding, as of the matrices below
      general.mass += 11.0;
      const auto one = isotropic(corners(), nu, plain, kind);
      const auto other = laminate(corners(), general, direction(), kind);
      EXPECT_LT(scaled_difference(other.stiffness[0].matrix, sum(one.stiffness, e, rho, t)), 7e-14);
      EXPECT_LT(scaled_difference(other.mass[0].matrix, sum(one.mass, e, rho, t)), 7e-15);
    }
}

TEST_P(LaminateLaws, SixMotionsAndNoMoreAreFree) {
  for (const double offset : {0.0, 0.07}) {
    auto property = any_laminate(0.06);
    property.offset = offset;
    const auto matrices = laminate(corners(), property, direction(), MassKind::consistent);
    EXPECT_TRUE(matrices.stiffness[0].powers == PropertyPowers{} && matrices.mass[0].powers == PropertyPowers{});
    for (const auto& terms : {matrices.stiffness, matrices.mass})
      EXPECT_TRUE(terms[0].matrix == terms[0].matrix.transpose());
    const Eigen::MatrixXd& k = matrices.stiffness[0].matrix;
    const Eigen::VectorXd scale = k.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::VectorXd values =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scale.asDiagonal() * k * scale.asDiagonal()).eigenvalues();
    EXPECT_LT(values.head(6).cwiseAbs().maxCoeff(), 1.5e-14) << values.transpose();  // rounding
    EXPECT_GT(values[6], 1e-9) << values.transpose();
    const Eigen::MatrixXd& m = matrices.mass[0].matrix;
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(m).eigenvalues()[0], 0.0);
  }
}

TEST_P(LaminateLaws, MatricesTurnWithTheElementAndItsDirection) {
  auto property = any_laminate(0.06);
  property.offset = 0.05;
  const auto element = laminate(corners(), property, direction(), MassKind::consistent);
  const auto other = laminate((some_turn() * corners()).colwise() + Eigen::Vector3d(1, 2, 3), property,
                              some_turn() * direction(), MassKind::consistent);
  // rounding
  EXPECT_LT(scaled_difference(other.stiffness[0].matrix, turned(element.stiffness[0].matrix, some_turn())), 4e-14);
  EXPECT_LT(scaled_difference(other.mass[0].matrix, turned(element.mass[0].matrix, some_turn())), 1e-14);
}

TEST_P(LaminateLaws, FirstCornerIsOfNoAccountWhereADirectionIsGiven) {
  const Eigen::Index n = corners().cols();
  Eigen::Matrix3Xd shifted(3, n);
  Eigen::VectorXi order(6 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    shifted.col(i) = corners().col((i + 1) % n);
    for (int k = 0; k < 6; ++k) order[6 * i + k] = static_cast<int>(6 * ((i + 1) % n) + k);
  }
  const auto property = any_laminate(0.06);
  const auto one = laminate(corners(), property, direction(), MassKind::consistent);
  const auto other = laminate(shifted, property, direction(), MassKind::consistent);
  EXPECT_LT(scaled_difference(other.stiffness[0].matrix, one.stiffness[0].matrix(order, order)), 2e-14);  // rounding
  // Without one, the first side is the direction.
  const auto none = laminate(corners(), property, Eigen::Vector3d::Zero(), MassKind::consistent);
  const auto side = laminate(corners(), property, corners().col(1) - corners().col(0), MassKind::consistent);
  EXPECT_LT(scaled_difference(none.stiffness[0].matrix, side.stiffness[0].matrix), 1e-14);
}

TEST_P(LaminateLaws, AngleOfAPlyTurnsFromTheDirectionAboutTheNormal) {
  const double angle = 0.7;
  const Eigen::Index last = corners().cols() - 1;
  const Eigen::Vector3d normal =
      (corners().col(2) - corners().col(0)).cross(corners().col(last) - corners().col(1)).normalized();
  const Eigen::Vector3d plane = direction() - direction().dot(normal) * normal;
  const Eigen::Vector3d fibres = Eigen::AngleAxisd(angle, normal) * plane;
  // Strong and mild: the triangle's share of the linear strains has a floor for the first.
  OrthotropicSheet mild = graphite;
  mild.youngs_modulus_1 = 2e9;
  for (const auto& sheet : {graphite, mild}) {
    const auto by_angle = laminated({{sheet, 0.02, angle}}, -0.01), along = laminated({{sheet, 0.02, 0.0}}, -0.01);
    // The normal of the diagonals is that of the centre, also where the surface is warped.
    // found 6.5e-14: rounding, magnified by the warp of the surface
    EXPECT_LT(scaled_difference(laminate(corners(), by_angle, plane, MassKind::consistent).stiffness[0].matrix,
                                laminate(corners(), along, fibres, MassKind::consistent).stiffness[0].matrix),
              7e-13);
  }
}

TEST_P(LaminateLaws, OffsetIsARigidLinkToTheMiddleSurface) {
  if (!GetParam().flat) return;
  const double h = 0.08;
  const Eigen::Vector3d normal = some_turn() * Eigen::Vector3d::UnitZ();
  const bool tilted = std::string(GetParam().name).find("tilted") != std::string::npos;
  const Eigen::Vector3d arm = h * (tilted ? normal : Eigen::Vector3d::UnitZ());
  auto property = any_laminate(0.06);
  property.offset = 0.0;
  const auto middle = laminate(corners().colwise() + arm, property, direction(), MassKind::consistent);
  property.offset = h;
  const auto off = laminate(corners(), property, direction(), MassKind::consistent);
  const Eigen::Index size = 6 * corners().cols();
  Eigen::MatrixXd link = Eigen::MatrixXd::Identity(size, size);  // u_middle = u + theta x arm
  for (Eigen::Index i = 0; i < corners().cols(); ++i)
    for (int k = 0; k < 3; ++k) link.block<3, 1>(6 * i, 6 * i + 3 + k) = Eigen::Vector3d::Unit(k).cross(arm);
  // rounding
  EXPECT_LT(scaled_difference(off.stiffness[0].matrix, link.transpose() * middle.stiffness[0].matrix * link), 1.5e-14);
  EXPECT_LT(scaled_difference(off.mass[0].matrix, link.transpose() * middle.mass[0].matrix * link), 1e-14);
}

INSTANTIATE_TEST_SUITE_P(Shapes, LaminateLaws, testing::ValuesIn(shapes()),
                         [](const auto& one) { return std::string(one.param.name); });

TEST(LaminateShapes, DirectionAlongTheNormalIsAShapeError) {
  for (const auto& shape : shapes()) {
    const Eigen::Index last = shape.corners.cols() - 1;
    const Eigen::Vector3d normal =
        (shape.corners.col(2) - shape.corners.col(0)).cross(shape.corners.col(last) - shape.corners.col(1));
    EXPECT_THROW(laminate(shape.corners, any_laminate(0.1), normal, MassKind::consistent), ElementShapeError);
  }
}

// Patch test --------------------------------------------------------------------------------------------------------

class LaminatePatch : public testing::TestWithParam<CellShape> {};

TEST_P(LaminatePatch, ConstantStrainsAndCurvaturesTogetherComeOutExactly) {
  // u = e x - z k..., all six at once, on a distorted mesh: inner nodes in balance, energy of A, B and D.
  const double a = 2.4, b = 1.2, t = 0.05;
  const auto property = any_laminate(t);
  const Eigen::Vector3d e(1.0, -0.6, 0.8), k(3.0, 2.0, -5.0);
  test::ShellProblem patch(
      {4, 3, GetParam(), true}, [&](double u, double v) { return Eigen::Vector3d(a * u, b * v, 0.0); }, {1.0, 0.3, 1.0},
      t);
  patch.model.properties["shell"] = property;
  std::get<LaminateProperty>(patch.model.properties["shell"]).directions = {{1.0, 0.0, 0.0}};
  const auto model = assemble(patch.model);
  const Eigen::MatrixXd stiffness(evaluate(model.stiffness, model.parameters));
  Eigen::VectorXd exact(stiffness.rows());
  std::vector<Eigen::Index> inner, outer;
  for (int j = 0; j <= 3; ++j)
    for (int i = 0; i <= 4; ++i) {
      const Eigen::Index node = patch.grid.node(i, j);
      const double x = patch.grid.mesh.nodes(0, node), y = patch.grid.mesh.nodes(1, node);
      // Turns of the normal b = [theta_y, -theta_x] = [k_x x + k_xy y / 2, k_xy x / 2 + k_y y] = -grad w.
      const double b_x = k[0] * x + 0.5 * k[2] * y, b_y = 0.5 * k[2] * x + k[1] * y;
      exact.segment<6>(6 * node) << e[0] * x + 0.5 * e[2] * y, 0.5 * e[2] * x + e[1] * y, -0.5 * (b_x * x + b_y * y),
          -b_y, b_x, 0.0;
      for (int d = 0; d < 6; ++d) (i > 0 && i < 4 && j > 0 && j < 3 ? inner : outer).push_back(6 * node + d);
    }
  const Eigen::VectorXd force = -stiffness(inner, outer) * exact(outer);
  const Eigen::VectorXd found = Eigen::MatrixXd(stiffness(inner, inner)).ldlt().solve(force);
  EXPECT_LT((found - exact(inner)).cwiseAbs().maxCoeff(), 1e-13);  // rounding
  const auto& s = property.stiffness;
  const double energy = a * b * (e.dot(s.membrane * e) + 2.0 * e.dot(s.coupling * k) + k.dot(s.bending * k));
  EXPECT_NEAR(exact.dot(stiffness * exact), energy, 2e-14 * energy);
  EXPECT_GT(std::abs(2.0 * e.dot(s.coupling * k)), 1e-3 * energy) << "the coupling has a part in it";
}

INSTANTIATE_TEST_SUITE_P(Cells, LaminatePatch, testing::Values(CellShape::quadrilateral4, CellShape::triangle3),
                         [](const auto& one) {
                           return one.param == CellShape::triangle3 ? "triangles" : "quadrilaterals";
                         });

// Lamination --------------------------------------------------------------------------------------------------------

/// Relative; found up to 7e-16.
constexpr double rounding = 7e-15;

TEST(Lamination, AntisymmetricLaminatesHaveTheStiffnessesOfTheory) {
  // [Jon99], regular antisymmetric: A = sum Q t, B = 1/2 sum Q (z_k^2 - z_k-1^2), D = 1/3 sum Q (z_k^3 - z_k-1^3).
  const double t = 0.02, free = 1.0 - 0.25 * 0.25 / 25.0;
  const double q11 = 25e9 / free, q22 = 1e9 / free, q12 = 0.25e9 / free, q66 = 0.5e9;
  const auto cross = laminated(stack({0, 90}, t), -0.5 * t).stiffness;
  // rounding of 1e8 N/m, of 1e5 N and of 1e2 N m
  EXPECT_NEAR(cross.membrane(0, 0), 0.5 * t * (q11 + q22), 3e-7);
  EXPECT_NEAR(cross.membrane(0, 1), t * q12, 3e-7);
  EXPECT_NEAR(cross.coupling(0, 0), t * t / 8.0 * (q22 - q11), 3e-9);  // the stiff ply is below
  EXPECT_NEAR(cross.coupling(1, 1), t * t / 8.0 * (q11 - q22), 3e-9);
  EXPECT_NEAR(cross.coupling(0, 1), 0.0, 3e-9);
  EXPECT_NEAR(cross.bending(0, 0), t * t * t / 24.0 * (q11 + q22), 2e-11);
  EXPECT_NEAR(cross.bending(2, 2), t * t * t / 12.0 * q66, 2e-11);

  const double invariant = 0.25 * (q11 + q22 - 2.0 * q12 - 4.0 * q66);
  const auto angle = laminated(stack({45, -45}, t), -0.5 * t).stiffness;
  EXPECT_NEAR(angle.membrane(0, 0), t * (0.25 * (q11 + q22 + 2.0 * q12) + q66), 3e-7);
  EXPECT_NEAR(angle.membrane(2, 2), t * (invariant + q66), 3e-7);
  EXPECT_NEAR(angle.membrane(0, 2), 0.0, 3e-7);
  // Q_16 of a ply at +45 is (Q11 - Q22) / 4: stretching it along x shears it from x to y; that ply is below.
  EXPECT_NEAR(angle.coupling(0, 2), -t * t / 4.0 * 0.25 * (q11 - q22), 3e-9);
  EXPECT_NEAR(angle.coupling(0, 0), 0.0, 3e-9);
}

TEST(Lamination, IsotropicPliesMakeAPlate) {
  const IsotropicMaterial material{7e10, 0.33, 2700.0};
  const double t = 0.01;
  std::vector<Ply> plies;
  for (const double part : {0.2, 0.5, 0.3}) plies.push_back({sheet_of(material), part * t, part});
  for (const auto shear : {TransverseShear::equilibrium, TransverseShear::five_sixths}) {
    const auto section = laminated(plies, 0.003, shear);
    const double modulus = 7e10 / (1.0 - 0.33 * 0.33);
    EXPECT_NEAR(section.stiffness.membrane(0, 0) / (modulus * t), 1.0, rounding);
    EXPECT_NEAR(section.stiffness.bending(0, 1) / (0.33 * modulus * t * t * t / 12.0), 1.0, rounding);
    EXPECT_LT(section.stiffness.coupling.norm(), rounding * modulus * t * t);
    EXPECT_NEAR(section.stiffness.shear(0, 0) / (5.0 / 6.0 * t * material.shear_modulus()), 1.0, rounding);
    EXPECT_NEAR(section.stiffness.shear(1, 1) / (5.0 / 6.0 * t * material.shear_modulus()), 1.0, rounding);
    EXPECT_NEAR(section.mass, 27.0, 5 * rounding);
    EXPECT_NEAR(section.rotary_inertia, 2700.0 * t * t * t / 12.0, 3e-19);
    EXPECT_NEAR(section.offset, 0.003 + 0.5 * t, 1e-17);
  }
}

TEST(Lamination, SandwichShearsInItsCore) {
  // Thin stiff faces: S = G d^2 / c with d between the middles of the faces and c the core's thickness, to (f/c)^2.
  const IsotropicMaterial face{7e10, 0.3, 2700.0};
  const double f = 0.0005, c = 0.03, g = 4e7;
  const OrthotropicSheet core{.youngs_modulus_1 = 1e4,
                              .youngs_modulus_2 = 1e4,
                              .poissons_ratio_12 = 0.1,
                              .shear_modulus_12 = 5e3,
                              .shear_modulus_13 = g,
                              .shear_modulus_23 = 0.5 * g,
                              .density = 50.0};
  const auto section = laminated({{sheet_of(face), f, 0.0}, {core, c, 0.0}, {sheet_of(face), f, 0.0}}, 0.0);
  const double expected = g * (c + f) * (c + f) / c;
  EXPECT_NEAR(section.stiffness.shear(0, 0) / expected, 1.0, 5e-4);  // (f/c)^2 = 2.8e-4, found 1.7e-4
  EXPECT_NEAR(section.stiffness.shear(1, 1) / (0.5 * expected), 1.0, 5e-4);
  EXPECT_NEAR(section.offset, f + 0.5 * c, 1e-17);
  EXPECT_NEAR(section.mass, 50.0 * c + 2.0 * 2700.0 * f, 5 * rounding);
}

TEST(Lamination, ShearStiffnessHasTheEnergyOfTheStressesInEquilibrium) {
  // Slice by slice: d tau / dz = -d sigma / dx under m_xx,x = q_x, and -d sigma / dy under m_yy,y = q_y [Roh88].
  const double t = 0.02;
  const std::vector<double> degrees = {30, -45, 80};
  const auto section = laminated(stack(degrees, t), -0.5 * t);
  const auto& s = section.stiffness;
  Eigen::MatrixXd joined(6, 6);
  joined << s.membrane, s.coupling, s.coupling, s.bending;
  const Eigen::MatrixXd from_moments = joined.inverse().rightCols(3);
  const int slices = 30000;  // the error is of their square: 1e-9 times the layers'
  Eigen::Matrix3d force = Eigen::Matrix3d::Zero();
  Eigen::Matrix2d energy = Eigen::Matrix2d::Zero();
  for (int i = 0; i < slices; ++i) {
    const double z = t * ((i + 0.5) / slices - 0.5);
    const auto ply = laminated({stack(degrees, t)[static_cast<std::size_t>(3 * i / slices)]}, 0.0).stiffness;
    const Eigen::Matrix3d slice =
        ply.membrane / (t / 3.0) * (t / slices) * (from_moments.topRows(3) + z * from_moments.bottomRows(3));
    const Eigen::Matrix3d f = force + 0.5 * slice;
    const Eigen::Matrix2d stresses{{f(0, 0), f(2, 1)}, {f(2, 0), f(1, 1)}};
    const Eigen::Matrix2d moduli = ply.shear / (5.0 / 6.0 * t / 3.0);
    energy += t / slices * stresses.transpose() * moduli.inverse() * stresses;
    force += slice;
  }
  EXPECT_LT(force.row(0).norm() + force(1, 1), 1e-13 / t) << "the upper side is free";  // rounding of the sum
  EXPECT_LT((s.shear - energy.inverse()).norm(), 3e-8 * s.shear.norm());                // found 8e-9
  const auto plain = laminated(stack(degrees, t), -0.5 * t, TransverseShear::five_sixths).stiffness.shear;
  EXPECT_GT((s.shear - plain).norm(), 0.01 * plain.norm());
}

TEST(Lamination, HeightIsThatOfTheCentreOfMass) {
  const IsotropicMaterial light{7e10, 0.3, 1000.0}, heavy{2e11, 0.3, 8000.0};
  const auto section = laminated({{sheet_of(light), 0.02, 0.0}, {sheet_of(heavy), 0.01, 0.0}}, -0.02);
  const double centre = (1000.0 * 0.02 * -0.01 + 8000.0 * 0.01 * 0.005) / 100.0;
  EXPECT_NEAR(section.offset, centre, 2e-17);  // rounding, as all of these
  const double about_nodes = (1000.0 * 8e-6 + 8000.0 * 1e-6) / 3.0;
  EXPECT_NEAR(section.rotary_inertia, about_nodes - 100.0 * centre * centre, 1e-17);
  // The stiffness about the nodes does not depend on where it is counted from.
  const double modulus = 7e10 / 0.91, other = 2e11 / 0.91;
  const double coupling = 0.5 * (-modulus * 4e-4 + other * 1e-4);
  EXPECT_NEAR(section.stiffness.coupling(0, 0) + centre * section.stiffness.membrane(0, 0), coupling, 1e-18 * modulus);
}

TEST(Lamination, WhatIsNotPhysicalIsToldTogether) {
  auto plies = stack({0, 90, 0}, 0.01);
  plies[0].thickness = 0.0;
  plies[1].material.poissons_ratio_12 = 5.5;
  plies[2].material.youngs_modulus_2 = std::nan("");
  try {
    laminated(plies, 0.0);
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_EQ(error.issues().size(), 3U) << error.what();
  }
  EXPECT_THROW(laminated({}, 0.0), InvalidInput);
  EXPECT_THROW(plate_section(SeparatePlate{}), InvalidInput);
}

TEST(Lamination, SeparatePlateHasItsResistances) {
  const auto sheet = sheet_of({7e10, 0.33, 2700.0});
  const double t = 0.004;
  const auto whole = laminated({{sheet, t, 0.0}}, -0.5 * t);
  SeparatePlate plate{.membrane = sheet, .bending = sheet, .shear = sheet, .thickness = t};
  auto section = plate_section(plate);
  EXPECT_LT((section.stiffness.membrane - whole.stiffness.membrane).norm(), rounding * whole.stiffness.membrane.norm());
  EXPECT_LT((section.stiffness.bending - whole.stiffness.bending).norm(), rounding * whole.stiffness.bending.norm());
  EXPECT_LT((section.stiffness.shear - whole.stiffness.shear).norm(), rounding * whole.stiffness.shear.norm());
  EXPECT_NEAR(section.mass, whole.mass, 5 * rounding);
  EXPECT_NEAR(section.rotary_inertia, whole.rotary_inertia, 3e-20);
  plate.bending_ratio = 4.0;
  plate.shear.reset();
  section = plate_section(plate);
  EXPECT_LT((section.stiffness.bending - 4.0 * whole.stiffness.bending).norm(),
            rounding * whole.stiffness.bending.norm());
  // without a material of its own it is stiff
  EXPECT_NEAR(section.stiffness.shear(0, 0) / whole.stiffness.shear(0, 0), 1e3, 1e3 * rounding);
}

// Whole plates ------------------------------------------------------------------------------------------------------

enum class Supports { cross_ply, angle_ply };

/// Frequencies [Hz] of a simply supported rectangular plate, waves m x n, lowest of each: amplitudes [U V W X Y] of the
/// displacements and turns of the normals, whose strains are orthogonal over the plate [Red04]. Cross-ply: u and X ~
/// cos a x sin b y, v and Y ~ sin cos, w ~ sin sin, edges slide normally (SS-1). Angle-ply: u ~ sin cos, v ~ cos sin,
/// edges slide along themselves (SS-2). Exact where the stiffnesses that would couple others vanish.
double navier_frequency(const LaminateProperty& plate, Supports supports, double a, double b, int m, int n) {
  const double p = m * pi / a, q = n * pi / b, side = supports == Supports::cross_ply ? 1.0 : -1.0;
  Eigen::Matrix<double, 8, 5> strains = Eigen::Matrix<double, 8, 5>::Zero();
  strains(0, 0) = -side * p, strains(1, 1) = -side * q;
  strains(2, 0) = side * q, strains(2, 1) = side * p;
  strains(3, 3) = -p, strains(4, 4) = -q, strains(5, 3) = q, strains(5, 4) = p;
  strains(6, 2) = p, strains(6, 3) = 1.0;
  strains(7, 2) = q, strains(7, 4) = 1.0;
  Eigen::Matrix<double, 8, 8> section = Eigen::Matrix<double, 8, 8>::Zero();
  section.topLeftCorner<6, 6>() << plate.stiffness.membrane, plate.stiffness.coupling, plate.stiffness.coupling,
      plate.stiffness.bending;
  section.bottomRightCorner<2, 2>() = plate.stiffness.shear;
  const Eigen::MatrixXd stiffness = strains.transpose() * section * strains;
  Eigen::MatrixXd mass = plate.mass * Eigen::MatrixXd::Identity(5, 5);
  mass(3, 3) = mass(4, 4) = plate.rotary_inertia;
  std::vector<int> present = {0, 1, 2, 3, 4};
  if (m == 0) present = {supports == Supports::cross_ply ? 0 : 1, 3};  // those without sin a x
  if (n == 0) present = {supports == Supports::cross_ply ? 1 : 0, 4};
  const Eigen::MatrixXd k = stiffness(present, present), inertia = mass(present, present);
  return std::sqrt(Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>(k, inertia).eigenvalues()[0]) / (2.0 * pi);
}

TEST(LaminatedPlates, ClosedFormHasTheLimitOfTheThinPlate) {
  // f = pi / (2 a^2) sqrt((D11 + 2 (D12 + 2 D66) + D22) / mass) of a square orthotropic plate [Jon99]; shear and rotary
  // inertia add the square of h / a.
  const double h = 1e-3;
  const auto plate = laminated(stack({0}, h), -0.5 * h);
  const auto& d = plate.stiffness.bending;
  const double thin = 0.5 * pi * std::sqrt((d(0, 0) + 2.0 * (d(0, 1) + 2.0 * d(2, 2)) + d(1, 1)) / plate.mass);
  // found 2.5e-5: E / G is large
  EXPECT_NEAR(navier_frequency(plate, Supports::cross_ply, 1.0, 1.0, 1, 1) / thin, 1.0, 6e-5);
}

/// The four lowest of all waves, ascending.
Eigen::ArrayXd lowest_navier(const LaminateProperty& plate, Supports supports, double a, double b) {
  std::vector<double> all;
  for (int m = 0; m <= 6; ++m)
    for (int n = m == 0 ? 1 : 0; n <= 6; ++n) all.push_back(navier_frequency(plate, supports, a, b, m, n));
  std::ranges::sort(all);
  return Eigen::Map<Eigen::ArrayXd>(all.data(), 4);
}

/// Lowest frequencies by finite elements over the closed form's.
Eigen::ArrayXd frequency_ratios(double thickness, Supports supports, const test::Cut& cut) {
  const double a = 1.0, b = 0.8;
  const bool cross = supports == Supports::cross_ply;
  test::ShellProblem problem(
      cut, [=](double u, double v) { return Eigen::Vector3d(a * u, b * v, 0.0); }, {1.0, 0.3, 1.0}, thickness);
  auto property = laminated(cross ? stack({0, 90}, thickness) : stack({45, -45}, thickness), -0.5 * thickness);
  property.directions = {{1.0, 0.0, 0.0}};
  problem.model.properties["shell"] = property;
  for (const int end : {0, 1}) {
    // Turns of the normals along an edge are held: X = theta_y at y = 0, b and Y = -theta_x at x = 0, a.
    problem.fix(problem.grid.side('u', end), {cross ? 1 : 0, 2, 3});
    problem.fix(problem.grid.side('v', end), {cross ? 0 : 1, 2, 4});
  }
  const auto model = assemble(problem.model);
  const auto modes =
      lowest_modes(evaluate(model.stiffness, model.parameters), evaluate(model.mass, model.parameters), {.count = 4});
  return modes.values.array().sqrt() / (2.0 * pi) / lowest_navier(property, supports, a, b);
}

class LaminatedPlate : public testing::TestWithParam<CellShape> {};

TEST_P(LaminatedPlate, AntisymmetricFrequenciesConvergeToTheClosedForm) {
  for (const double thickness : {0.01, 0.08})
    for (const auto supports : {Supports::cross_ply, Supports::angle_ply}) {
      const auto error = [&](int count) {
        return Eigen::ArrayXd(frequency_ratios(thickness, supports, {count, count, GetParam(), false}) - 1.0);
      };
      const auto coarse = error(12), fine = error(24);
      // found .021 and .0145
      EXPECT_LT(fine.abs().maxCoeff(), GetParam() == CellShape::triangle3 ? 0.03 : 0.02) << fine.transpose();
      // Order h^2: found .249 to .261.
      EXPECT_LT((fine.abs() / coarse.abs()).maxCoeff(), 0.3) << coarse.transpose() << "\n" << fine.transpose();
      // Small errors are differences of two, of which the closed form's own rotary inertia is one.
      const Eigen::ArrayXd order = (coarse.abs() > 0.005).select(fine.abs() / coarse.abs(), 0.25);
      EXPECT_GT(order.minCoeff(), 0.2) << coarse.transpose() << "\n" << fine.transpose();
    }
}

INSTANTIATE_TEST_SUITE_P(Cells, LaminatedPlate, testing::Values(CellShape::quadrilateral4, CellShape::triangle3),
                         [](const auto& one) {
                           return one.param == CellShape::triangle3 ? "triangles" : "quadrilaterals";
                         });

/// Motion of the middle of the end of a strip 1 x 0.1 clamped at the other, pulled along x at its nodes.
Eigen::Matrix<double, 6, 1> pulled_strip(const RegionProperty& property, CellShape shape) {
  test::ShellProblem strip(
      {20, 2, shape, false}, [](double u, double v) { return Eigen::Vector3d(u, 0.1 * v, 0.0); }, {7e10, 0.0, 2700.0},
      0.02);
  strip.model.properties["shell"] = property;
  strip.fix(strip.grid.side('u', 0), {0, 1, 2, 3, 4, 5});
  strip.load_side(strip.grid.side('u', 1), 0, 1e4);
  return test::solve(strip).segment<6>(6 * strip.grid.node(20, 1));
}

TEST(LaminatedPlates, PlateAboveItsNodesIsCoupledByItsOffset) {
  // N at the nodes, a distance e below the middle: curvature -N e / D, so that the strip rises by N e L^2 / 2 D, with
  // B = A e and D + A e^2 about the nodes.
  const double e = 0.03, t = 0.02, modulus = 7e10, force = 1e4 / 0.1;
  const double rise = force * e / (2.0 * modulus * t * t * t / 12.0);
  const double stretch = force / (modulus * t) + 2.0 * e * rise;
  const ShellProperty above{.material = "material", .thickness = t, .offset = e};
  auto about_nodes = laminated({{sheet_of({modulus, 0.0, 2700.0}), t, 0.0}}, -0.5 * t);
  about_nodes.stiffness.coupling = e * about_nodes.stiffness.membrane;
  about_nodes.stiffness.bending += e * e * about_nodes.stiffness.membrane;
  for (const auto shape : {CellShape::quadrilateral4, CellShape::triangle3})
    for (const RegionProperty& property : {RegionProperty(above), RegionProperty(about_nodes)}) {
      // Rectangles bend exactly, to rounding times the condition, found 6e-11; triangles to h^2, found 9.6e-4.
      const double tolerance = shape == CellShape::quadrilateral4 ? 6e-10 : 1.2e-3;
      const auto tip = pulled_strip(property, shape);
      EXPECT_NEAR(tip[2] / rise, 1.0, tolerance);
      EXPECT_NEAR(tip[4] / (-2.0 * rise), 1.0, tolerance);
      EXPECT_NEAR(tip[0] / stretch, 1.0, tolerance);
    }
}

TEST(LaminatedPlates, OffsetPlateHasItsMassAboveItsNodes) {
  const double e = 0.03, t = 0.02;
  for (const auto kind : {MassKind::consistent, MassKind::lumped})
    for (const auto shape : {CellShape::quadrilateral4, CellShape::triangle3}) {
      test::ShellProblem plate(
          {3, 2, shape, true}, [](double u, double v) { return Eigen::Vector3d(u, 0.5 * v, 0.0); }, {7e10, 0.3, 2700.0},
          t);
      plate.model.properties["shell"] =
          ShellProperty{.material = "material", .thickness = t, .offset = e, .nonstructural_mass = 20.0};
      plate.model.mass_kind = kind;
      const auto found = mass_properties(assemble(plate.model));
      EXPECT_NEAR(found.mass, 0.5 * (2700.0 * t + 20.0), 1.5e-13);  // rounding, as of all
      EXPECT_LT((found.centre - Eigen::Vector3d(0.5, 0.25, e)).norm(), 2e-15);
      EXPECT_NEAR(found.centre.z(), e, 1e-16);
      if (kind == MassKind::lumped) continue;  // at the nodes, not over the area
      EXPECT_NEAR(found.inertia(0, 0), found.mass * 0.25 / 12.0 + 0.5 * 2700.0 * t * t * t / 12.0, 1.5e-14);
    }
}

}  // namespace
}  // namespace kalfem
