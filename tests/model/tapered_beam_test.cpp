// SPDX-License-Identifier: Apache-2.0
// Beams whose section changes along the line, against beam(), closed forms and chains of many prismatic ones.
#include "kalfem/model/elements/tapered_beam.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "kalfem/model/elements/beam_forces.hpp"

namespace kalfem {
namespace {

constexpr double nu = 0.3, modulus = 2e11, density = 7800.0, span = 2.0;

using Ends = Eigen::Matrix<double, 3, 2>;

Ends along_x(double length = span) {
  Ends ends = Ends::Zero();
  ends(0, 1) = length;
  return ends;
}

BeamSection section(double scale, double shear_factor = 0.0) {
  BeamSection section{.area = 1e-3 * scale,
                      .inertia_y = 1e-6 * scale * scale,
                      .inertia_z = 2e-6 * scale * scale,
                      .torsion = 2.5e-6 * scale * scale};
  section.shear_factor_y = shear_factor;
  section.shear_factor_z = 0.8 * shear_factor;
  return section;
}

/// With places and scales of section().
BeamProperty tapered(const std::vector<std::pair<double, double>>& scales, double shear_factor = 0.0) {
  BeamProperty property;
  for (const auto& [place, scale] : scales)
    property.stations.push_back({.place = place, .section = section(scale, shear_factor)});
  property.section = mean_station(property.stations).section;
  return property;
}

Eigen::MatrixXd stiffness_of(const BeamProperty& property, double length = span) {
  return modulus *
         beam(along_x(length), property, property.placement(0), nu, MassKind::consistent).stiffness.front().matrix;
}

Eigen::MatrixXd mass_of(const BeamProperty& property, MassKind kind, double length = span) {
  const auto terms = beam(along_x(length), property, property.placement(0), nu, kind).mass;
  Eigen::MatrixXd mass = density * terms.front().matrix;
  for (std::size_t i = 1; i < terms.size(); ++i) mass += terms[i].matrix;
  return mass;
}

/// Motion of the free end in the direction of a unit load there, the first end held.
double tip_flexibility(const BeamProperty& property, int direction) {
  const Eigen::MatrixXd free = stiffness_of(property).bottomRightCorner<6, 6>();
  return free.inverse()(direction, direction);
}

TEST(TaperedBeams, WithEqualStationsAreBeams) {
  BeamProperty plain;
  plain.section = section(1.0, 0.5);
  plain.section.product_yz = 4e-7;
  plain.section.centroid = {0.01, -0.02};
  plain.nonstructural_mass = 3.0;
  plain.nonstructural_centre = {-0.03, 0.01};
  for (const bool hinged : {false, true}) {
    if (hinged) plain.placements.front().released[10] = true;
    BeamProperty stations = plain;
    for (const double place : {0.0, 0.3, 1.0})
      stations.stations.push_back({.place = place,
                                   .section = plain.section,
                                   .nonstructural_mass = plain.nonstructural_mass,
                                   .nonstructural_inertia = 0.0,
                                   .nonstructural_centre = plain.nonstructural_centre});
    const Eigen::MatrixXd expected = stiffness_of(plain);
    // rounding of the inverse of the flexibility
    EXPECT_NEAR((stiffness_of(stations) - expected).norm(), 0.0, 1e-11 * expected.norm());
    for (const auto kind : {MassKind::consistent, MassKind::lumped}) {
      const Eigen::MatrixXd mass = mass_of(plain, kind);
      EXPECT_NEAR((mass_of(stations, kind) - mass).norm(), 0.0, 1e-11 * mass.norm());
    }
    Eigen::VectorXd motions = Eigen::VectorXd::LinSpaced(12, -1e-3, 1e-3);
    const IsotropicMaterial steel{modulus, nu, density};
    const Ends pull = Ends::Constant(9.81);
    const auto forces = beam_forces(along_x(), stations, stations.placement(0), steel, MassKind::consistent, motions,
                                    {pull}),
               plain_forces =
                   beam_forces(along_x(), plain, plain.placement(0), steel, MassKind::consistent, motions, {pull});
    for (const std::size_t end : {0, 1})
      EXPECT_NEAR((forces[end] - plain_forces[end]).norm(), 0.0, 1e-10 * plain_forces[end].norm());
    const auto geometric = beam_geometric_stiffness(along_x(), stations, stations.placement(0), nu, 1e4),
               plain_geometric = beam_geometric_stiffness(along_x(), plain, plain.placement(0), nu, 1e4);
    EXPECT_NEAR((geometric - plain_geometric).norm(), 0.0, 1e-11 * plain_geometric.norm());
  }
}

/// I from 1 to 16 and back, as int (L - x)^2 / (E I) dx by Simpson's rule of many steps.
TEST(TaperedBeams, BendByTheirFlexibility) {
  BeamProperty property;
  for (const auto& [place, factor] : {std::pair{0.0, 1.0}, {0.4, 16.0}, {0.6, 16.0}, {1.0, 1.0}}) {
    BeamSection own = section(1.0);
    own.inertia_y = own.inertia_z = 1e-6 * factor;
    property.stations.push_back({.place = place, .section = own});
  }
  property.section = mean_station(property.stations).section;
  const auto inertia = [](double s) {
    return 1e-6 * (s < 0.4 ? 1.0 + 15.0 * s / 0.4 : s < 0.6 ? 16.0 : 1.0 + 15.0 * (1.0 - s) / 0.4);
  };
  double expected = 0.0;
  constexpr int steps = 100'000;
  for (int i = 0; i <= steps; ++i) {
    const double s = static_cast<double>(i) / steps, weight = i == 0 || i == steps ? 1.0 : i % 2 == 1 ? 4.0 : 2.0;
    expected += weight * span / steps / 3.0 * std::pow(span * (1.0 - s), 2) / (modulus * inertia(s));
  }
  EXPECT_NEAR(tip_flexibility(property, 1), expected, 1e-8 * expected);
  EXPECT_NEAR(tip_flexibility(property, 2), expected, 1e-8 * expected);
  EXPECT_NEAR(1000.0 * tip_flexibility(property, 1), 2.5406e-3, 5e-8);
}

TEST(TaperedBeams, StretchAndTwistByTheLogarithmOfTheirTaper) {
  BeamProperty property = tapered({{0.0, 1.0}, {1.0, 1.0}});
  property.stations.back().section.area = 5e-3;
  property.stations.back().section.torsion = 8e-5;
  property.section = mean_station(property.stations).section;
  EXPECT_NEAR(tip_flexibility(property, 0), span * std::log(5.0) / (modulus * 4e-3), 1e-17);
  const double shear_modulus = modulus / (2.0 * (1.0 + nu));
  EXPECT_NEAR(tip_flexibility(property, 3) * shear_modulus * 7.75e-5 / (span * std::log(32.0)), 1.0, 1e-8);
}

/// Assembled matrices of a chain of prismatic beams with the sections at their middles.
std::pair<Eigen::MatrixXd, Eigen::MatrixXd> chain(const BeamProperty& property, int count, MassKind kind) {
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(6 * count + 6, 6 * count + 6), mass = stiffness;
  for (int i = 0; i < count; ++i) {
    BeamProperty part;
    const auto middle = station_at(property.stations, (i + 0.5) / count);
    part.section = middle.section;
    part.nonstructural_mass = middle.nonstructural_mass;
    part.nonstructural_centre = middle.nonstructural_centre;
    stiffness.block<12, 12>(6 * i, 6 * i) += stiffness_of(part, span / count);
    mass.block<12, 12>(6 * i, 6 * i) += mass_of(part, kind, span / count);
  }
  return {stiffness, mass};
}

/// A chain reduced to its ends by its static motions is the element, but for the steps: found 4e-5 and 3e-4,
/// a quarter of that with twice as many.
TEST(TaperedBeams, AreTheLimitOfChains) {
  BeamProperty property = tapered({{0.0, 1.0}, {0.35, 3.0}, {1.0, 0.6}}, 0.6);
  property.stations[0].section.centroid = {0.01, 0.0};
  property.stations[1].section.centroid = {0.03, -0.02};
  property.stations[1].section.product_yz = 3e-6;
  property.stations[2].nonstructural_mass = 5.0;
  property.stations[2].nonstructural_centre = {0.02, 0.04};
  property.section = mean_station(property.stations).section;
  constexpr int count = 200;
  const auto [stiffness, mass] = chain(property, count, MassKind::consistent);
  std::vector<int> ends, inner;
  for (int i = 0; i < stiffness.rows(); ++i) (i < 6 || i >= 6 * count ? ends : inner).push_back(i);
  Eigen::MatrixXd motions = Eigen::MatrixXd::Zero(stiffness.rows(), 12);
  motions(ends, Eigen::all).setIdentity();
  motions(inner, Eigen::all) =
      -Eigen::MatrixXd(stiffness(inner, inner)).ldlt().solve(Eigen::MatrixXd(stiffness(inner, ends)));
  const Eigen::MatrixXd reduced = motions.transpose() * stiffness * motions,
                        heavy = motions.transpose() * mass * motions;
  EXPECT_NEAR((stiffness_of(property) - reduced).norm(), 0.0, 1e-4 * reduced.norm());
  EXPECT_NEAR((mass_of(property, MassKind::consistent) - heavy).norm(), 0.0, 5e-4 * heavy.norm());
}

TEST(TaperedBeams, KeepTheirMassAndItsCentre) {
  const BeamProperty property = tapered({{0.0, 1.0}, {0.4, 4.0}, {0.6, 4.0}, {1.0, 1.0}});
  EXPECT_NEAR(property.section.area, 2.8e-3, 1e-15);
  for (const auto kind : {MassKind::consistent, MassKind::lumped}) {
    const Eigen::MatrixXd mass = mass_of(property, kind);
    Eigen::VectorXd shift = Eigen::VectorXd::Zero(12);
    shift[1] = shift[7] = 1.0;
    EXPECT_NEAR(shift.dot(mass * shift), 43.68, 1e-10);
  }
  // A linear taper from A to 3 A has its centre at 7 / 12 of the length.
  const Eigen::MatrixXd mass = mass_of(tapered({{0.0, 1.0}, {1.0, 3.0}}), MassKind::lumped);
  EXPECT_NEAR(mass(6, 6) / (mass(0, 0) + mass(6, 6)), 7.0 / 12.0, 1e-12);
}

}  // namespace
}  // namespace kalfem
