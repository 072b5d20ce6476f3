// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/elements/beam.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/model/assembly/rigid_body.hpp"
#include "model/beam_models.hpp"

namespace kalfem {
namespace {

using namespace test;
using std::numbers::pi;

ElementMatrices beam(const Ends& ends, const BeamProperty& property, double poissons_ratio, MassKind mass_kind) {
  return kalfem::beam(ends, property, property.placements[0], poissons_ratio, mass_kind);
}

/// Natural frequencies [rad/s] of motion in the x-z plane only.
Eigen::VectorXd plane_frequencies(FiniteElementModel model, const std::vector<FixedNodes>& supports) {
  std::vector<Eigen::Index> all(static_cast<std::size_t>(model.mesh.node_count()));
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<Eigen::Index>(i);
  model.fixed = supports;
  model.fixed.push_back({.name = "plane", .nodes = all, .directions = {true, true, false, true, false, true}});
  const auto assembled = assemble(model);
  const auto modes =
      normal_modes(evaluate(assembled.mass, assembled.parameters), evaluate(assembled.stiffness, assembled.parameters));
  return 2.0 * pi * modes.frequencies;
}

/// Relative; found up to 3e-16.
constexpr double rounding = 4e-15;

TEST(BeamSections, RectangleHasTheTabulatedTorsionConstants) {
  // Timoshenko and Goodier, Theory of Elasticity, table of k1 = J / (a c^3) with four digits.
  EXPECT_NEAR(rectangular_section(1.0, 1.0).torsion, 0.1406, 5e-5);
  EXPECT_NEAR(rectangular_section(2.0, 1.0).torsion / 2.0, 0.229, 5e-4);
  EXPECT_NEAR(rectangular_section(1.0, 5.0).torsion / 5.0, 0.291, 5e-4);
  // 1/3 (1 - 192/pi^5 sum(1/n^5) c/a), odd n
  EXPECT_NEAR(rectangular_section(1.0, 1000.0).torsion / 1000.0, (1.0 - 0.630249e-3) / 3.0, 1e-9);
  const auto section = rectangular_section(0.2, 0.3, 0.0);
  EXPECT_DOUBLE_EQ(section.area, 0.06);
  EXPECT_DOUBLE_EQ(section.inertia_y, 0.2 * 0.027 / 12.0);
  EXPECT_DOUBLE_EQ(section.inertia_z, 0.3 * 0.008 / 12.0);
  EXPECT_DOUBLE_EQ(section.shear_factor_y, 5.0 / 6.0);  // without lateral contraction
}

TEST(BeamSections, CirclesAndTubesAgreeAtTheirLimits) {
  const auto solid = circular_section(0.1);
  // rounding of m^2 and m^4
  EXPECT_NEAR(solid.area, pi * 0.0025, 1e-17);
  EXPECT_NEAR(solid.torsion, pi * 1e-4 / 32.0, 3e-20);
  EXPECT_NEAR(solid.shear_factor_y, 6.0 * 1.3 / 8.8, rounding);
  const auto tube = circular_tube_section(0.1, 0.02);
  EXPECT_NEAR(tube.inertia_y, solid.inertia_y - circular_section(0.06).inertia_y, 1e-20);
  EXPECT_NEAR(tube.area, solid.area - circular_section(0.06).area, 1e-17);
  // Hole closing: the solid's factor; wall vanishing: 2 (1 + nu) / (4 + 3 nu) [Cow66]; off by the
  // square of the ratio of the radii or of wall to radius.
  EXPECT_NEAR(circular_tube_section(0.1, 0.04999).shear_factor_y, solid.shear_factor_y, 3e-7);
  EXPECT_NEAR(circular_tube_section(0.1, 1e-6).shear_factor_z, 2.0 * 1.3 / 4.9, 5e-10);
}

TEST(BeamSections, RectangularTubeIsTheDifferenceOfTwoRectangles) {
  const auto tube = rectangular_tube_section(0.06, 0.04, 0.003);
  const auto outer = rectangular_section(0.06, 0.04), inner = rectangular_section(0.054, 0.034);
  // rounding, as above
  EXPECT_NEAR(tube.area, outer.area - inner.area, 2e-18);
  EXPECT_NEAR(tube.inertia_y, outer.inertia_y - inner.inertia_y, 1e-21);
  EXPECT_NEAR(tube.inertia_z, outer.inertia_z - inner.inertia_z, 1e-21);
  // A square of middle line a: Bredt's a^3 t, and 4 a t^3 / 3 of the walls alone.
  EXPECT_NEAR(rectangular_tube_section(0.11, 0.11, 0.01).torsion, 1e-3 * 0.01 + 4.0 * 0.1 * 1e-6 / 3.0, 2e-20);
  // A deep narrow box is two webs, whose factor is that of a rectangle [Cow66]; the flanges' share is of the order
  // 1e-8.
  EXPECT_NEAR(rectangular_tube_section(1e-4, 1.0, 1e-6).shear_factor_z, 13.0 / 15.3, 1e-7);
  // In the box of width twice its depth the walls along the force carry the shear: about their share of the area.
  EXPECT_LT(tube.shear_factor_z, tube.shear_factor_y);
  EXPECT_NEAR(tube.shear_factor_y, 0.6, 0.08);
}

TEST(BeamSections, RectangularTubeHasTheShearFactorOfItsShearEnergy) {
  // Without lateral contraction k = I^2 / (A int q^2 / t ds) with the shear flow q = t int z ds of a unit Q / I. For a
  // thin wall t on the middle line b x h: q = t h/2 s along half a flange, t (h b / 4 + (h^2/4 - z^2) / 2) along a web.
  const double t = 1e-6, b = 0.05, h = 0.08;
  const auto section = rectangular_tube_section(b + t, h + t, t, 0.0);
  const double flanges = t * h * h * b * b * b / 24.0;
  const double webs = 2.0 * t * (h * h * h * b * b / 16.0 + std::pow(h, 4) * b / 24.0 + std::pow(h, 5) / 120.0);
  // The exact inertia differs from that of the middle line by the square of t / h, found 4e-10.
  EXPECT_NEAR(section.shear_factor_z / (std::pow(section.inertia_y, 2) / (section.area * (flanges + webs))), 1.0, 1e-9);
}

TEST(BeamSections, ImpossibleLengthsAreRefused) {
  EXPECT_NE(message_of([] { rectangular_section(0.0, 1.0); }).find("rectangular section is 0"), std::string::npos);
  EXPECT_NE(message_of([] { circular_section(std::nan("")); }).find("circular"), std::string::npos);
  EXPECT_NE(message_of([] { circular_tube_section(0.1, 0.05); }).find("leaves no hole"), std::string::npos);
  EXPECT_NE(message_of([] { rectangular_tube_section(0.1, 0.02, 0.01); }).find("leaves no hole"), std::string::npos);
}

TEST(Beam, CantileverUnderEndLoadsIsExactWithAnyNumberOfElements) {
  const double length = 0.5, load = 100.0;
  const auto section = rectangular_section(0.1, 0.2);
  const double e = steel.youngs_modulus, g = steel.shear_modulus();
  for (const int count : {1, 2, 5}) {
    const auto model = beam_model({length, 0.0, 0.0}, count, section);
    const auto tip = [&](int direction) {
      return tip_motion(model, load * Eigen::Matrix<double, 6, 1>::Unit(direction));
    };
    const double shear = load * length / (g * section.shear_factor_z * section.area);
    const double bending_z = load * std::pow(length, 3) / (3.0 * e * section.inertia_y);
    // Rounding of the solution grows with the number of elements: found 7e-15.
    EXPECT_NEAR(tip(2)[2] / (bending_z + shear), 1.0, 7e-14) << count;
    EXPECT_NEAR(tip(2)[4] / (-load * length * length / (2.0 * e * section.inertia_y)), 1.0, 7e-14);
    EXPECT_NEAR(tip(1)[1] / (load * std::pow(length, 3) / (3.0 * e * section.inertia_z) + shear), 1.0, 7e-14);
    EXPECT_NEAR(tip(1)[5] / (load * length * length / (2.0 * e * section.inertia_z)), 1.0, 7e-14);
    EXPECT_NEAR(tip(0)[0] / (load * length / (e * section.area)), 1.0, 7e-14);
    EXPECT_NEAR(tip(3)[3] / (load * length / (g * section.torsion)), 1.0, 7e-14);
    EXPECT_NEAR(tip(5)[1] / (load * length * length / (2.0 * e * section.inertia_z)), 1.0, 7e-14);
  }
}

TEST(Beam, EulerBernoulliCantileverConvergesAtTheFourthOrder) {
  // Roots of cos x cosh x = -1 with ten digits.
  const std::array roots = {1.8751040687, 4.6940911330, 7.8547574382};
  const auto section = slender();
  const double length = 1.3;
  const double unit =
      std::sqrt(steel.youngs_modulus * section.inertia_y / (steel.density * section.area)) / (length * length);
  const auto error = [&](int count, std::size_t mode) {
    const auto found =
        plane_frequencies(beam_model({length, 0.0, 0.0}, count, section), {{.name = "clamp", .nodes = {0}}});
    return found[static_cast<Eigen::Index>(mode)] / (roots[mode] * roots[mode] * unit) - 1.0;
  };
  for (std::size_t mode = 0; mode < roots.size(); ++mode) {
    const double coarse = error(8, mode), fine = error(16, mode);
    EXPECT_GT(fine, 0.0) << "a consistent mass and compatible shapes approach from above";
    EXPECT_NEAR(std::log2(coarse / fine), 4.0, 0.1) << mode;  // found within .065: the sixth order, on 8 elements
    EXPECT_LT(fine, 8e-5);                                    // found 4e-5 in the third
  }
}

TEST(Beam, TimoshenkoSimplySupportedFrequenciesConvergeToTheClosedForm) {
  // With deflection sin(b x), b = n pi / L: rho^2 I / (k G) w^4 - (rho A + (rho I + E I rho / (k G)) b^2) w^2 + E I b^4
  // = 0 (Timoshenko 1921). The shear is constant in an element, so the order is 2.
  const auto section = rectangular_section(0.1, 0.2);
  const double length = 1.0, e = steel.youngs_modulus, rho = steel.density, i = section.inertia_y;
  const double kg = section.shear_factor_z * steel.shear_modulus();
  const auto exact = [&](int n) {
    const double b2 = std::pow(n * pi / length, 2);
    const double a = rho * rho * i / kg, p = rho * section.area + (rho * i + e * i * rho / kg) * b2,
                 c = e * i * b2 * b2;
    return std::sqrt(2.0 * c / (p + std::sqrt(p * p - 4.0 * a * c)));
  };
  const auto error = [&](int count, int n) {
    const auto found =
        plane_frequencies(beam_model({length, 0.0, 0.0}, count, section),
                          {{.name = "ends", .nodes = {0, count}, .directions = {true, true, true, true, false, true}}});
    return std::abs(found[n - 1] / exact(n) - 1.0);
  };
  for (const int n : {1, 2, 3}) {
    EXPECT_LT(error(32, n), 5e-5 * std::pow(n, 4)) << n;  // found 3.5e-5 n^4, less in the higher ones
    EXPECT_NEAR(std::log2(error(16, n) / error(32, n)), 2.0, 0.015) << n;
  }
}

TEST(Beam, LumpedMassConvergesToTheSameFrequenciesAtTheSecondOrderOrBetter) {
  auto section = slender();
  const double length = 1.3;
  const double exact = std::pow(4.6940911330, 2) / (length * length) *
                       std::sqrt(steel.youngs_modulus * section.inertia_y / (steel.density * section.area));
  const auto error = [&](int count) {
    auto model = beam_model({length, 0.0, 0.0}, count, section);
    model.mass_kind = MassKind::lumped;
    return std::abs(plane_frequencies(model, {{.name = "clamp", .nodes = {0}}})[1] / exact - 1.0);
  };
  EXPECT_NEAR(std::log2(error(16) / error(32)), 2.0, 0.05);  // found to be the second
  EXPECT_LT(error(32), 4e-3);                                // found .002
}

TEST(Beam, FreeElementHasSixMotionsWithoutStrain) {
  const Ends ends{{0.1, 0.7}, {0.2, -0.3}, {-0.4, 0.5}};
  for (const auto& section : {slender(), rectangular_section(0.1, 0.2)}) {
    const auto matrices = beam(ends, beam_property(section, {0.01, 0.02, -0.03}), 0.3, MassKind::consistent);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrices.stiffness.at(0).matrix);
    const double largest = solver.eigenvalues()[11];
    EXPECT_LT(solver.eigenvalues().head(6).cwiseAbs().maxCoeff(), rounding * largest);
    EXPECT_GT(solver.eigenvalues()[6], 1e-7 * largest);  // slenderness squared
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> inertia(matrices.mass.at(0).matrix);
    EXPECT_GT(inertia.eigenvalues()[0], 0.0);
  }
}

TEST(Beam, MatricesTurnWithTheFrame) {
  const Ends ends{{0.0, 0.4}, {0.1, -0.2}, {0.3, 0.35}};
  const auto property = beam_property(rectangular_tube_section(0.06, 0.04, 0.003), {0.02, 0.0, 0.05}, {0.2, 0.1, 1.0});
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
  BeamProperty turned = property;
  turned.placements[0].up = turn * property.placements[0].up;
  turned.placements[0].offsets = turn * property.placements[0].offsets;
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(12, 12);
  for (int i = 0; i < 4; ++i) all.block<3, 3>(3 * i, 3 * i) = turn;
  for (const auto kind : {MassKind::consistent, MassKind::lumped}) {
    const auto here = beam(ends, property, 0.3, kind), there = beam(turn * ends, turned, 0.3, kind);
    EXPECT_LT(difference(there.stiffness.at(0).matrix, all * here.stiffness.at(0).matrix * all.transpose()), rounding);
    EXPECT_LT(difference(there.mass.at(0).matrix, all * here.mass.at(0).matrix * all.transpose()), rounding);
  }
}

TEST(Beam, SectionAxesFollowUp) {
  // Deep in `up`: bending towards `up` is the stiff one, whatever the direction of the beam.
  const auto section = rectangular_section(0.02, 0.2);
  auto model = beam_model({0.0, 0.0, 2.0}, 1, section);
  std::get<BeamProperty>(model.properties["line"]).placements[0].up = {0.0, 3.0, 1.0};
  const auto tip = [&](int direction) {
    return tip_motion(model, Eigen::Matrix<double, 6, 1>::Unit(direction))[direction];
  };
  const auto expected = [&](double inertia, double shear_factor) {
    return 8.0 / (3.0 * steel.youngs_modulus * inertia) + 2.0 / (steel.shear_modulus() * shear_factor * section.area);
  };
  EXPECT_NEAR(tip(1) / expected(section.inertia_y, section.shear_factor_z), 1.0, rounding);
  EXPECT_NEAR(tip(0) / expected(section.inertia_z, section.shear_factor_y), 1.0, rounding);
}

TEST(Beam, RigidMotionHasTheMassAndInertiaOfTheBar) {
  const double length = 0.8;
  const auto section = rectangular_section(0.1, 0.2);
  for (const auto kind : {MassKind::consistent, MassKind::lumped}) {
    auto model = beam_model({length, 0.0, 0.0}, 1, section);
    model.mass_kind = kind;
    const auto properties = mass_properties(assemble(model));
    const double mass = steel.density * section.area * length;
    EXPECT_NEAR(properties.mass / mass, 1.0, rounding);
    EXPECT_LT((properties.centre - Eigen::Vector3d(length / 2.0, 0.0, 0.0)).norm(), rounding);
    EXPECT_NEAR(properties.inertia(0, 0) / (steel.density * (section.inertia_y + section.inertia_z) * length), 1.0,
                rounding);
    if (kind == MassKind::lumped) continue;  // its rotations are scaled for frequencies
    EXPECT_NEAR(properties.inertia(1, 1) / (mass * length * length / 12.0 + steel.density * section.inertia_y * length),
                1.0, rounding);
    EXPECT_NEAR(properties.inertia(2, 2) / (mass * length * length / 12.0 + steel.density * section.inertia_z * length),
                1.0, 4 * rounding);
  }
}

TEST(Beam, OffsetIsARigidLinkToABeamWithoutOffset) {
  const Eigen::Vector3d offset(0.03, -0.05, 0.1);
  const auto section = rectangular_section(0.04, 0.06);
  auto moved = beam_model({1.0, 0.4, -0.2}, 1, section);
  std::get<BeamProperty>(moved.properties["line"]).placements[0].offsets = offset.replicate<1, 2>();
  FiniteElementModel linked = beam_model({1.0, 0.4, -0.2}, 1, section);
  linked.mesh.nodes.colwise() += offset;
  for (const Eigen::Index end : {0, 1}) {
    const auto master = add_node(linked.mesh, linked.mesh.nodes.col(end) - offset);
    linked.links.push_back({.name = "arm" + std::to_string(end), .master = master, .slaves = {end}});
  }
  const auto one = assemble(moved), other = assemble(linked);
  ASSERT_EQ(other.size(), 12);
  EXPECT_LT(difference(stiffness_of(one), stiffness_of(other)), rounding);
  EXPECT_LT(difference(mass_of(one), mass_of(other)), rounding);
}

TEST(Beam, ImpossibleGeometryIsAShapeError) {
  const auto property = beam_property(rectangular_section(0.1, 0.1));
  EXPECT_THROW(beam(Ends{{1.0, 1.0}, {2.0, 2.0}, {3.0, 3.0}}, property, 0.3, MassKind::consistent), ElementShapeError);
  EXPECT_THROW(beam(Ends{{1.0, 1.0}, {2.0, 2.0}, {3.0, 4.0}}, property, 0.3, MassKind::consistent), ElementShapeError);
  BeamProperty without_up = property;
  without_up.placements[0].up.setZero();
  EXPECT_THROW(beam(Ends{{0.0, 1.0}, {0.0, 0.0}, {0.0, 0.0}}, without_up, 0.3, MassKind::consistent),
               ElementShapeError);
}

TEST(BeamParts, EachFactorMultipliesItsOwnStiffness) {
  const double length = 0.5, load = 100.0, e = steel.youngs_modulus, g = steel.shear_modulus();
  const auto section = rectangular_section(0.1, 0.2);
  auto model = beam_model({length, 0.0, 0.0}, 2, section);
  model.fixed = {{.name = "clamp", .nodes = {0}}};
  const auto assembled = assemble(model, {.parameters = {"line.torsion"}});
  auto parameters = assembled.parameters;
  const std::map<std::string, double> factors = {
      {"line.axial", 2.0}, {"line.bending_y", 3.0}, {"line.bending_z", 5.0}, {"line.torsion", 7.0}};
  for (const auto& [name, value] : factors) {
    EXPECT_EQ(parameters.at(name), 1.0);
    parameters.at(name) = value;
  }
  const Eigen::MatrixXd stiffness(evaluate(assembled.stiffness, parameters));
  const auto tip = [&](int direction) {
    return stiffness.ldlt().solve(load * Eigen::VectorXd::Unit(12, 6 + direction))[6 + direction];
  };
  // Bending and its shear flexibility together.
  const double bending_y = std::pow(length, 3) / (3.0 * e * section.inertia_y);
  const double bending_z = std::pow(length, 3) / (3.0 * e * section.inertia_z);
  const double shear = length / (g * section.shear_factor_z * section.area);
  EXPECT_NEAR(tip(0) / (load * length / (e * section.area)), 1.0 / 2.0, rounding);
  EXPECT_NEAR(tip(2) / (load * (bending_y + shear)), 1.0 / 3.0, rounding);
  EXPECT_NEAR(tip(1) / (load * (bending_z + shear)), 1.0 / 5.0, rounding);
  EXPECT_NEAR(tip(3) / (load * length / (g * section.torsion)), 1.0 / 7.0, rounding);
}

TEST(BeamParts, TheirSumIsTheWholeStiffness) {
  const Ends ends{{0.1, 0.7}, {0.2, -0.3}, {-0.4, 0.5}};
  auto property = beam_property(rectangular_section(0.1, 0.2), {0.01, 0.02, -0.03}, {0.2, 0.1, 1.0});
  property.section.centroid = {0.01, -0.02};
  const auto check = [&](const std::vector<BeamPart>& expected) {
    const auto& placement = property.placements[0];
    ASSERT_EQ(parts_of(property), expected);
    const auto parts = kalfem::beam(ends, property, placement, 0.3, MassKind::consistent, expected);
    const auto whole = kalfem::beam(ends, property, placement, 0.3, MassKind::consistent);
    ASSERT_EQ(parts.stiffness.size(), expected.size());
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(12, 12);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const auto& term = parts.stiffness[i];
      EXPECT_EQ(term.powers, (PropertyPowers{.youngs_modulus = 1, .part = expected[i]}));
      const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(term.matrix).eigenvalues();
      EXPECT_GT(values[0], -rounding * values[11]) << "each part takes work";
      sum += term.matrix;
    }
    EXPECT_LT(difference(sum, whole.stiffness.at(0).matrix), rounding);
    EXPECT_EQ(parts.mass.at(0).matrix, whole.mass.at(0).matrix);
  };
  check({BeamPart::axial, BeamPart::bending_y, BeamPart::bending_z, BeamPart::torsion});
  property.section.product_yz = 1e-5;
  check({BeamPart::axial, BeamPart::bending, BeamPart::torsion});
  property.placements[0].released[4] = true;
  check({BeamPart::stiffness});
}

TEST(Beam, RoundSectionsStandUprightWithoutAnUp) {
  const Ends upright{{0.1, 0.1}, {0.2, 0.2}, {0.0, 1.5}};
  const auto stiffness = [&](const BeamProperty& property) {
    return beam(upright, property, 0.3, MassKind::consistent).stiffness[0].matrix;
  };
  const Eigen::Vector3d none = Eigen::Vector3d::Zero(), up = Eigen::Vector3d::UnitZ();
  for (const auto& section : {circular_section(0.03), circular_tube_section(0.03, 0.002)}) {
    const auto turned = stiffness(beam_property(section, none, {0.6, -0.8, 0.0}));
    EXPECT_LT((stiffness(beam_property(section, none, up)) - turned).norm(), 1e-14 * turned.norm());
  }
  EXPECT_THROW(stiffness(beam_property(rectangular_section(0.03, 0.03), none, up)), ElementShapeError);
  auto eccentric = beam_property(circular_section(0.03), none, up);
  eccentric.nonstructural_centre = {0.0, 0.01};
  EXPECT_THROW(stiffness(eccentric), ElementShapeError);
  auto hinged = beam_property(circular_section(0.03), none, up);
  hinged.placements[0].released[4] = true;
  EXPECT_THROW(stiffness(hinged), ElementShapeError);
}

}  // namespace
}  // namespace kalfem
