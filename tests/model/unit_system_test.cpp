// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/unit_system.hpp"

#include <gtest/gtest.h>

#include "kalfem/model/assembly/assembly.hpp"
#include "model/fe_models.hpp"

namespace kalfem {
namespace {

using namespace test;

/// A plate with a rib, a body, springs, a lever and a matrix.
FiniteElementModel workpiece() {
  auto model = model_of(plate_mesh(1.0, 0.8, 2, 2));
  model.properties["plate"] = ShellProperty{"steel", 0.01, 0.002, 3.0};
  add_cell(model.mesh, "rib", CellShape::line2, {0, 1});
  auto rib = beam_property(rectangular_section(0.02, 0.03), {0.0, 0.01, 0.02});
  rib.section.centroid = {0.001, 0.002};
  rib.nonstructural_mass = 0.4;
  rib.nonstructural_centre = {0.003, 0.0};
  model.properties["rib"] = rib;
  model.masses = {{"motor", 4, 5.0, 0.2 * Eigen::Matrix3d::Identity(), {0.0, 0.1, 0.05}}};
  NodalSpring leg;
  leg.name = "leg";
  leg.from = {8, 2};
  leg.stiffness = 1e4;
  leg.damping = 20.0;
  NodalSpring hinge = leg;
  hinge.name = "hinge";
  hinge.from = {6, 3};
  model.springs = {leg, hinge};
  model.joints = {{"lever", {{{2, 2}, 1.0}, {{2, 4}, 0.3}, {{5, 2}, -1.0}}, 2e4, 5.0}};
  Eigen::SparseMatrix<double> matrix(2, 2);
  matrix.insert(0, 0) = 3.0;
  matrix.insert(1, 1) = 0.4;
  matrix.insert(0, 1) = matrix.insert(1, 0) = 0.2;
  model.matrices = {{"other", {{3, 2}, {3, 3}}, 1e3 * matrix, matrix, 10.0 * matrix}};
  model.constraints = {{"tie", {{{7, 2}, 1.0}, {{4, 2}, -1.0}, {{4, 3}, -0.4}}}};
  return model;
}

/// The same with its numbers in mm, t and s (so N, MPa, t/mm^3).
FiniteElementModel in_millimetres() {
  auto model = workpiece();
  model.mesh.nodes *= 1e3;
  model.materials["steel"].youngs_modulus *= 1e-6;
  model.materials["steel"].density *= 1e-12;
  auto& plate = std::get<ShellProperty>(model.properties["plate"]);
  plate.thickness *= 1e3;
  plate.offset *= 1e3;
  plate.nonstructural_mass *= 1e-9;
  auto& rib = std::get<BeamProperty>(model.properties["rib"]);
  rib.section.area *= 1e6;
  for (double* inertia : {&rib.section.inertia_y, &rib.section.inertia_z, &rib.section.torsion}) *inertia *= 1e12;
  rib.section.centroid *= 1e3;
  rib.placements[0].offsets *= 1e3;
  rib.nonstructural_mass *= 1e-6;
  rib.nonstructural_centre *= 1e3;
  model.masses[0].mass *= 1e-3;
  model.masses[0].inertia *= 1e3;
  model.masses[0].offset *= 1e3;
  model.springs[0].stiffness *= 1e-3;
  model.springs[0].damping *= 1e-3;
  model.springs[1].stiffness *= 1e3;
  model.springs[1].damping *= 1e3;
  model.joints[0].deformation[1].second *= 1e3;
  model.joints[0].stiffness *= 1e-3;
  model.joints[0].damping *= 1e-3;
  const Eigen::Vector2d lengths(1.0, 1e3);
  auto& other = model.matrices[0];
  other.stiffness = scaled(other.stiffness, 1e-3, lengths);
  other.damping = scaled(other.damping, 1e-3, lengths);
  other.mass = scaled(other.mass, 1e-3, lengths);
  model.constraints[0].terms[2].second *= 1e3;
  return model;
}

/// Relative: factors of ten are not exact. Found up to 2e-16.
constexpr double rounding = 2e-15;

TEST(UnitSystem, AModelInMillimetresAndTonnesIsTheSameInSi) {
  auto model = in_millimetres();
  to_si(model, {.length = 1e-3, .mass = 1e3, .time = 1.0});
  const auto expected = assemble(workpiece()), found = assemble(model);
  EXPECT_LT(difference(stiffness_of(found), stiffness_of(expected)), rounding);
  EXPECT_LT(difference(mass_of(found), mass_of(expected)), rounding);
  EXPECT_LT(difference(Eigen::MatrixXd(found.damping), Eigen::MatrixXd(expected.damping)), rounding);
  EXPECT_NEAR(found.grounds[0].stiffness.norm() / expected.grounds[0].stiffness.norm(), 1.0, rounding);
}

TEST(UnitSystem, MilliSecondsCountInStiffnessAndDamping) {
  auto model = workpiece();
  const auto before = assemble(model);
  to_si(model, {.length = 1.0, .mass = 1.0, .time = 1e-3});
  const auto after = assemble(model);
  EXPECT_LT(difference(stiffness_of(after), 1e6 * stiffness_of(before)), rounding);
  EXPECT_LT(difference(Eigen::MatrixXd(after.damping), 1e3 * Eigen::MatrixXd(before.damping)), rounding);
  EXPECT_LT(difference(mass_of(after), mass_of(before)), rounding);
}

TEST(UnitSystem, GeneralisedCoordinatesOfMassNormalisedModesKeepTheirMassOfOne) {
  // A body of 2 t on a mode of mass 1: the coupling entry is sqrt(mass) length.
  const UnitSystem units{.length = 1e-3, .mass = 1e3, .time = 1.0};
  const auto factors = unit_factors({0, 3, -1}, units);
  EXPECT_DOUBLE_EQ(units.mass * factors[2] * factors[2], 1.0);
  EXPECT_DOUBLE_EQ(units.mass * factors[0] * factors[0], 1e3);
  EXPECT_DOUBLE_EQ(units.mass * factors[1] * factors[1], 1e-3);
}

}  // namespace
}  // namespace kalfem
