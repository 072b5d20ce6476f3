// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "kalfem/model/assembly/rigid_body.hpp"
#include "kalfem/model/elements/beam.hpp"
#include "model/beam_models.hpp"

// Sections of general position: bending planes that are coupled, a centroid off the shear centre, offsets of the ends,
// hinges and nonstructural mass, against closed forms.

namespace kalfem {
namespace {

using namespace test;
using std::numbers::pi;
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// An unequal angle: no axis of symmetry.
BeamSection angle_section() {
  BeamSection section;
  section.area = 1.9e-3;
  section.inertia_y = 2.6e-6;
  section.inertia_z = 0.9e-6;
  section.product_yz = -0.85e-6;
  section.torsion = 6e-8;
  return section;
}

/// A channel with its web along z: the shear centre lies behind the web, the centroid before it.
BeamSection channel_section() {
  BeamSection section;
  section.area = 2.4e-3;
  section.inertia_y = 6e-6;
  section.inertia_z = 1.1e-6;
  section.torsion = 8e-8;
  section.shear_factor_y = 0.4;
  section.shear_factor_z = 0.5;
  section.centroid = {0.045, 0.0};
  return section;
}

BeamSection any_section() {
  auto section = angle_section();
  section.shear_factor_y = 0.45;
  section.shear_factor_z = 0.6;
  section.centroid = {0.02, -0.035};
  return section;
}

/// [I_z, I_yz; I_yz, I_y], which joins the loads [Y Z] with the curvatures of [v w].
Eigen::Matrix2d moments(const BeamSection& section) {
  return Eigen::Matrix2d{{section.inertia_z, section.product_yz}, {section.product_yz, section.inertia_y}};
}

/// Of the norm of what is compared; found up to 4e-16.
constexpr double rounding = 4e-15;

TEST(BeamSection, UnsymmetricBendingFollowsBothPlanes) {
  // v'' E I = M with the matrix I: the tip moves by L^3 / 3 E I^-1 F and turns by L^2 / 2 E I^-1 F, and the shear adds
  // L F / (k G A) along each axis.
  const double length = 1.2, e = steel.youngs_modulus;
  auto section = angle_section();
  for (const bool soft : {false, true}) {
    section.shear_factor_y = soft ? 0.45 : 0.0;
    section.shear_factor_z = soft ? 0.6 : 0.0;
    for (const int count : {1, 3}) {
      const Eigen::Vector2d load(300.0, -500.0);
      const Vector6 tip = tip_motion(beam_model({length, 0.0, 0.0}, count, section),
                                     (Vector6() << 0.0, load, 0.0, 0.0, 0.0).finished());
      const Eigen::Vector2d bent = moments(section).inverse() * load / e;
      Eigen::Vector2d deflection = std::pow(length, 3) / 3.0 * bent;
      if (soft)
        deflection += length / (steel.shear_modulus() * section.area) *
                      load.cwiseQuotient(Eigen::Vector2d(section.shear_factor_y, section.shear_factor_z));
      const Eigen::Vector2d slope = 0.5 * length * length * bent;
      // found 1.4e-14: rounding grows with the number of elements
      EXPECT_LT((tip.segment<2>(1) - deflection).norm(), 1.5e-13 * deflection.norm()) << count;
      EXPECT_LT((Eigen::Vector2d(tip[5], -tip[4]) - slope).norm(), 1.5e-13 * slope.norm()) << count;
      EXPECT_LT(std::abs(tip[3]), 1e-16);
    }
  }
}

TEST(BeamSection, TurnedSectionIsTheSectionInTurnedAxes) {
  // A rectangle whose axes are turned by an angle within the section, by its second moments or by `up`.
  const auto principal = rectangular_section(0.02, 0.06);
  const double angle = 0.6, c = std::cos(angle), s = std::sin(angle);
  auto turned = principal;
  turned.inertia_y = c * c * principal.inertia_y + s * s * principal.inertia_z;
  turned.inertia_z = s * s * principal.inertia_y + c * c * principal.inertia_z;
  turned.product_yz = -s * c * (principal.inertia_y - principal.inertia_z);
  const Ends ends{{0.0, 1.0}, {0.0, 0.0}, {0.0, 0.0}};
  for (const auto kind : {MassKind::consistent, MassKind::lumped}) {
    const auto one = beam(ends, beam_property(turned), {}, 0.3, kind);
    const BeamPlacement placement{.up = {0.0, -s, c}, .offsets = Ends::Zero(), .released = {}};
    const auto other = beam(ends, beam_property(principal), placement, 0.3, kind);
    EXPECT_LT(difference(one.stiffness[0].matrix, other.stiffness[0].matrix), rounding);
    EXPECT_LT(difference(one.mass[0].matrix, other.mass[0].matrix), rounding);
  }
}

TEST(BeamSection, LoadThroughTheShearCentreDoesNotTwist) {
  const auto section = channel_section();
  const double length = 0.9, load = 1000.0;
  const auto at_shear_centre = beam_model({length, 0.0, 0.0}, 2, section);
  const Vector6 vertical = load * Vector6::Unit(2);
  const double straight = load * std::pow(length, 3) / (3.0 * steel.youngs_modulus * section.inertia_y) +
                          load * length / (0.5 * steel.shear_modulus() * section.area);
  const Vector6 tip = tip_motion(at_shear_centre, vertical);
  EXPECT_LT(std::abs(tip[3]), 1e-17);  // rounding; off the centre it twists by .006
  EXPECT_NEAR(tip[2], straight, rounding * straight);

  // Nodes at the centroid: the shear centre's line stands off them by minus the centroid, and the load twists.
  auto at_centroid = at_shear_centre;
  std::get<BeamProperty>(at_centroid.properties["line"]).placements[0].offsets.row(1).setConstant(-0.045);
  const Vector6 twisted = tip_motion(at_centroid, vertical);
  const double twist = load * 0.045 * length / (steel.shear_modulus() * section.torsion);
  EXPECT_NEAR(twisted[3], twist, 1e-14 * twist);
  EXPECT_NEAR(twisted[2], straight + 0.045 * twist, 1e-14 * twisted[2]);
}

TEST(BeamSection, AxialForceActsAtTheCentroid) {
  // N on the line of shear centres bends by the couples N z_c, -N y_c: u_c = N L / E A, and the line's end, which turns
  // with the section, moves by u = u_c - z_c theta_y + y_c theta_z.
  auto section = angle_section();
  section.centroid = {0.02, -0.035};
  const double length = 0.8, force = 2e4, e = steel.youngs_modulus;
  for (const int count : {1, 4}) {
    const Vector6 tip = tip_motion(beam_model({length, 0.0, 0.0}, count, section), force * Vector6::Unit(0));
    // The couple of N at -r_c from the centroid, as bending [theta_z', -theta_y']: E I [theta_z', -theta_y'] = N r_c.
    const Eigen::Vector2d curvature = moments(section).inverse() * section.centroid * force / e;
    const Eigen::Vector2d slope = length * curvature;
    // found 2e-14: rounding grows with the number of elements
    EXPECT_NEAR(tip[5], slope[0], 2e-13 * slope.norm()) << count;
    EXPECT_NEAR(-tip[4], slope[1], 2e-13 * slope.norm());
    EXPECT_NEAR(tip[1], 0.5 * length * slope[0], 2e-13 * slope.norm());
    EXPECT_NEAR(tip[2], 0.5 * length * slope[1], 2e-13 * slope.norm());
    const double end = force * length / (e * section.area) + section.centroid.dot(slope);
    EXPECT_NEAR(tip[0], end, 2e-13 * end);
  }
}

TEST(BeamSection, OffsetsOfTheEndsAreRigidLinks) {
  Ends offsets;
  offsets.col(0) = Eigen::Vector3d(0.03, -0.05, 0.1);
  offsets.col(1) = Eigen::Vector3d(-0.02, 0.04, -0.07);
  const BeamPlacement placement{.up = {0.1, 0.2, 1.0}, .offsets = offsets, .released = {}};
  auto moved = beam_model({1.0, 0.4, -0.2}, 1, any_section());
  std::get<BeamProperty>(moved.properties["line"]).placements[0] = placement;
  auto linked = moved;
  linked.mesh.nodes += offsets;
  std::get<BeamProperty>(linked.properties["line"]).placements[0].offsets.setZero();
  for (const Eigen::Index end : {0, 1}) {
    const auto master = add_node(linked.mesh, linked.mesh.nodes.col(end) - offsets.col(end));
    linked.links.push_back({.name = "arm" + std::to_string(end), .master = master, .slaves = {end}});
  }
  const auto one = assemble(moved), other = assemble(linked);
  ASSERT_EQ(other.size(), 12);
  EXPECT_LT(difference(stiffness_of(one), stiffness_of(other)), rounding);
  EXPECT_LT(difference(mass_of(one), mass_of(other)), rounding);
}

// Hinges ------------------------------------------------------------------------------------------------------------

/// Frequencies [rad/s] of the bending of beams between clamped ends in the x-z plane.
Eigen::VectorXd clamped_frequencies(FiniteElementModel model) {
  std::vector<Eigen::Index> all;
  for (Eigen::Index i = 0; i < model.mesh.node_count(); ++i) all.push_back(i);
  model.fixed = {{.name = "ends", .nodes = {0, all.back()}},
                 {.name = "plane", .nodes = all, .directions = {true, true, false, true, false, true}}};
  const auto assembled = assemble(model);
  return 2.0 * pi *
         normal_modes(evaluate(assembled.mass, assembled.parameters),
                      evaluate(assembled.stiffness, assembled.parameters))
             .frequencies;
}

/// Each cell with a placement of its own.
void hinge(FiniteElementModel& model, std::size_t cell, int local_motion) {
  auto& beam = std::get<BeamProperty>(model.properties["line"]);
  beam.placements.resize(model.mesh.regions.at("line").size(), beam.placements.front());
  beam.placements[cell].released[static_cast<std::size_t>(local_motion)] = true;
}

TEST(BeamHinges, HingedEndsOfAClampedBeamAreSimpleSupports) {
  const double length = 1.3;
  const auto section = slender();
  const double unit =
      std::sqrt(steel.youngs_modulus * section.inertia_y / (steel.density * section.area)) / (length * length);
  auto model = beam_model({length, 0.0, 0.0}, 16, section);
  hinge(model, 0, 4);
  const auto propped = clamped_frequencies(model);
  hinge(model, 15, 10);
  // discretisation: of fourth order, found 1e-6 n^4
  const auto supported = clamped_frequencies(model);
  for (int n = 1; n <= 3; ++n)
    EXPECT_NEAR(supported[n - 1] / (n * n * pi * pi * unit), 1.0, 2e-6 * std::pow(n, 4)) << n;
  // Roots of tan x = tanh x.
  EXPECT_NEAR(propped[0] / (3.926602312 * 3.926602312 * unit), 1.0, 6e-6);
  EXPECT_NEAR(propped[1] / (7.068582745 * 7.068582745 * unit), 1.0, 6e-5);
}

TEST(BeamHinges, HingeAmidTwoBeamsLeavesTheirAngleFree) {
  // Two cantilevers that meet at a hinge, loaded there: 2 * 3 E I / (L/2)^3.
  const double length = 2.0, load = 100.0;
  const auto section = slender();
  auto model = beam_model({length, 0.0, 0.0}, 2, section);
  hinge(model, 0, 10);
  model.fixed = {{.name = "ends", .nodes = {0, 2}}};
  const auto assembled = assemble(model);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(assembled.size());
  const auto w = assembled.find({1, 2});
  force[w] = load;
  const double deflection = stiffness_of(assembled).ldlt().solve(force)[w];
  EXPECT_NEAR(deflection / (load / (6.0 * steel.youngs_modulus * section.inertia_y)), 1.0, rounding);
}

TEST(BeamHinges, MassFollowsTheReleasedShape) {
  // Released at one end, the element moves as u = (3 s - s^3) / 2 under that end's unit deflection: int u^2 = 33 / 140.
  const auto section = slender();
  BeamPlacement placement;
  placement.released[10] = true;
  const Ends ends{{0.0, 0.7}, {0.0, 0.0}, {0.0, 0.0}};
  const auto matrices = beam(ends, beam_property(section), placement, 0.3, MassKind::consistent);
  EXPECT_NEAR(matrices.stiffness[0].matrix(8, 8), 3.0 * section.inertia_y / std::pow(0.7, 3),
              rounding * section.inertia_y / std::pow(0.7, 3));
  EXPECT_NEAR(matrices.mass[0].matrix(8, 8) / (section.area * 0.7), 33.0 / 140.0, rounding);
  EXPECT_TRUE(matrices.stiffness[0].matrix.row(10).isZero(rounding * section.inertia_y));
  EXPECT_TRUE(matrices.mass[0].matrix.row(10).isZero(rounding * section.area));
}

TEST(BeamHinges, ReleasedMotionsThatLeaveAMechanismAreRefused) {
  const Ends ends{{0.1, 0.7}, {0.2, -0.3}, {-0.4, 0.5}};
  const auto with = [&](std::initializer_list<std::size_t> motions) {
    BeamPlacement placement;
    for (const auto motion : motions) placement.released[motion] = true;
    return beam(ends, beam_property(any_section()), placement, 0.3, MassKind::consistent);
  };
  EXPECT_THROW(with({0, 6}), ElementShapeError);         // slides along
  EXPECT_THROW(with({3, 9}), ElementShapeError);         // turns
  EXPECT_THROW(with({2, 4, 8}), ElementShapeError);      // swings
  EXPECT_THROW(with({1, 5, 7, 11}), ElementShapeError);  // floats
  EXPECT_NO_THROW(with({4, 5, 10, 11}));                 // a strut
  EXPECT_NO_THROW(with({0, 3, 4, 5}));
  auto section = any_section();
  section.torsion = 0.0;
  BeamPlacement twist;
  twist.released[3] = true;
  EXPECT_THROW(beam(ends, beam_property(section), twist, 0.3, MassKind::consistent), ElementShapeError);
}

// Mass --------------------------------------------------------------------------------------------------------------

TEST(BeamMass, RigidMotionHasTheMassOfBothKindsAtTheirCentres) {
  const double length = 0.8, extra = 5.0;
  const auto section = any_section();
  for (const auto kind : {MassKind::consistent, MassKind::lumped}) {
    auto model = beam_model({length, 0.0, 0.0}, 2, section);
    model.mass_kind = kind;
    auto& property = std::get<BeamProperty>(model.properties["line"]);
    property.nonstructural_mass = extra;
    property.nonstructural_centre = {-0.01, 0.06};
    const auto properties = mass_properties(assemble(model));
    const double own = steel.density * section.area * length, added = extra * length, total = own + added;
    EXPECT_NEAR(properties.mass / total, 1.0, rounding);
    const Eigen::Vector2d centre = (own * section.centroid + added * property.nonstructural_centre) / total;
    EXPECT_LT((properties.centre - Eigen::Vector3d(length / 2.0, centre.x(), centre.y())).norm(), rounding);
    // About the centre of mass, along x: polar inertia of the section and both masses off that centre.
    const double polar = steel.density * (section.inertia_y + section.inertia_z) * length +
                         own * (section.centroid - centre).squaredNorm() +
                         added * (property.nonstructural_centre - centre).squaredNorm();
    EXPECT_NEAR(properties.inertia(0, 0) / polar, 1.0, 7e-14);  // moments about the origin cancel
    if (kind == MassKind::lumped) continue;                     // its rotations are scaled for frequencies
    const auto off = [&](int axis) {
      return own * std::pow(section.centroid[axis] - centre[axis], 2) +
             added * std::pow(property.nonstructural_centre[axis] - centre[axis], 2);
    };
    const double along = total * length * length / 12.0;
    EXPECT_NEAR(properties.inertia(1, 1) / (along + steel.density * section.inertia_y * length + off(1)), 1.0,
                rounding);
    EXPECT_NEAR(properties.inertia(2, 2) / (along + steel.density * section.inertia_z * length + off(0)), 1.0,
                rounding);
    const double product = own * (section.centroid - centre).prod() +
                           added * (property.nonstructural_centre - centre).prod() +
                           steel.density * section.product_yz * length;
    EXPECT_NEAR(properties.inertia(1, 2) / -product, 1.0, rounding);
  }
}

TEST(BeamMass, NonstructuralMassHasATermWithoutPowers) {
  auto property = beam_property(slender());
  property.nonstructural_mass = 3.0;
  const Ends ends{{0.0, 0.7}, {0.0, 0.0}, {0.0, 0.0}};
  const auto matrices = beam(ends, property, {}, 0.3, MassKind::consistent);
  ASSERT_EQ(matrices.mass.size(), 2U);
  EXPECT_EQ(matrices.mass[0].powers, (PropertyPowers{.density = 1}));
  EXPECT_EQ(matrices.mass[1].powers, PropertyPowers{});
  // The same line of mass as the section's own, but for its polar inertia.
  Eigen::MatrixXd own = 3.0 / property.section.area * matrices.mass[0].matrix;
  for (const int i : {3, 9}) own.row(i).setZero();
  EXPECT_LT(difference(matrices.mass[1].matrix, own), rounding);
}

// Laws --------------------------------------------------------------------------------------------------------------

BeamProperty any_property() {
  auto property = beam_property(any_section());
  property.nonstructural_mass = 2.0;
  property.nonstructural_centre = {0.03, 0.01};
  return property;
}

BeamPlacement any_placement() {
  BeamPlacement placement;
  placement.up = {0.2, 0.1, 1.0};
  placement.offsets << 0.02, -0.03, 0.0, 0.05, 0.05, 0.01;
  return placement;
}

TEST(BeamSectionLaws, SixMotionsAndThoseOfTheHingesAreFree) {
  const Ends ends{{0.1, 0.7}, {0.2, -0.3}, {-0.4, 0.5}};
  for (const int hinges : {0, 1, 2}) {
    auto placement = any_placement();
    if (hinges > 0) placement.released[10] = true;
    if (hinges > 1) placement.released[5] = true;
    const auto matrices = beam(ends, any_property(), placement, 0.3, MassKind::consistent);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrices.stiffness[0].matrix);
    const double largest = solver.eigenvalues()[11];
    EXPECT_LT(solver.eigenvalues().head(6 + hinges).cwiseAbs().maxCoeff(), rounding * largest);
    EXPECT_GT(solver.eigenvalues()[6 + hinges], 1e-7 * largest);  // slenderness squared
    const Eigen::MatrixXd mass = 7850.0 * matrices.mass[0].matrix + matrices.mass[1].matrix;
    const Eigen::VectorXd masses = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(mass).eigenvalues();
    EXPECT_GT(masses[0], hinges == 0 ? 0.0 : -1e-14 * masses[11]);  // a released motion has none, but for rounding
  }
}

TEST(BeamSectionLaws, MatricesTurnWithTheFrame) {
  const Ends ends{{0.0, 0.4}, {0.1, -0.2}, {0.3, 0.35}};
  auto placement = any_placement();
  placement.released[4] = placement.released[11] = true;
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
  auto turned = placement;
  turned.up = turn * placement.up;
  turned.offsets = turn * placement.offsets;
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(12, 12);
  for (int i = 0; i < 4; ++i) all.block<3, 3>(3 * i, 3 * i) = turn;
  for (const auto kind : {MassKind::consistent, MassKind::lumped}) {
    const auto here = beam(ends, any_property(), placement, 0.3, kind),
               there = beam(turn * ends, any_property(), turned, 0.3, kind);
    EXPECT_LT(difference(there.stiffness[0].matrix, all * here.stiffness[0].matrix * all.transpose()), rounding);
    for (std::size_t i = 0; i < 2; ++i)
      EXPECT_LT(difference(there.mass[i].matrix, all * here.mass[i].matrix * all.transpose()), rounding);
  }
}

TEST(BeamSectionLaws, EndsSwapWithTheirOffsetsAndHinges) {
  // Local x and y turn round: y_c changes its sign, I_yz too.
  const Ends ends{{0.0, 0.4}, {0.1, -0.2}, {0.3, 0.35}};
  auto placement = any_placement();
  placement.released[4] = placement.released[11] = true;
  BeamPlacement swapped{.up = placement.up, .offsets = placement.offsets.rowwise().reverse(), .released = {}};
  swapped.released[10] = swapped.released[5] = true;
  auto property = any_property(), mirrored = any_property();
  mirrored.section.centroid.x() *= -1.0;
  mirrored.section.product_yz *= -1.0;
  mirrored.nonstructural_centre.x() *= -1.0;
  const auto one = beam(ends, property, placement, 0.3, MassKind::consistent);
  const auto other = beam(ends.rowwise().reverse(), mirrored, swapped, 0.3, MassKind::consistent);
  std::vector<int> order;
  for (int i = 0; i < 12; ++i) order.push_back((i + 6) % 12);
  EXPECT_LT(difference(other.stiffness[0].matrix(order, order), one.stiffness[0].matrix), rounding);
  EXPECT_LT(difference(other.mass[0].matrix(order, order), one.mass[0].matrix), rounding);
  EXPECT_LT(difference(other.mass[1].matrix(order, order), one.mass[1].matrix), rounding);
}

}  // namespace
}  // namespace kalfem
