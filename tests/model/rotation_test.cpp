// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/statics/rotation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/figures.hpp"
#include "kalfem/model/statics/statics.hpp"
#include "model/fe_models.hpp"
#include "model/preloaded.hpp"
#include "model/shell_models.hpp"

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// A cantilever of 1 m along x, clamped at the axis of rotation, as slender as Euler and Bernoulli's beam.
FiniteElementModel blade(int count) {
  auto section = rectangular_section(0.02, 0.005);
  section.shear_factor_y = section.shear_factor_z = 0.0;
  auto model = beam_model({1.0, 0.0, 0.0}, count, section);
  model.fixed = {{"hub", {0}, {true, true, true, true, true, true}}};
  return model;
}

LoadCase turning(double speed, const Vector3d& axis = Vector3d::UnitZ(), const Vector3d& about = Vector3d::Zero()) {
  return {.name = "turning", .rotation = Rotation{axis, about, speed}};
}

/// sqrt(E I / rho A L^4) of bending along z and along y [rad/s].
double unit_frequency(double thickness) {
  return std::sqrt(steel.youngs_modulus * thickness * thickness / 12.0 / steel.density);
}

// N = rho A W^2 (L^2 - x^2) / 2 and u(L) = rho W^2 L^3 / 3 E, wherever the origin is.
TEST(Rotation, StretchesABarAsItsMassPulls) {
  const double speed = 300.0, pull = steel.density * 1e-4 * speed * speed;
  for (const auto mass : {MassKind::consistent, MassKind::lumped})
    for (const Vector3d& shift : {Vector3d(0.0, 0.0, 0.0), Vector3d(5.0, -3.0, 2.0)}) {
      auto model = blade(40);
      model.mass_kind = mass;
      model.mesh.nodes.colwise() += shift;
      const LoadCase load = turning(speed, {0.0, 0.0, 2.0}, shift + Vector3d(0.0, 0.0, 7.0));
      const auto solution = solve_statics(model, load);
      const double stretch = steel.density * speed * speed / (3.0 * steel.youngs_modulus);
      EXPECT_NEAR(solution.displacements[6 * 40], stretch, 1e-3 * stretch);
      EXPECT_NEAR(solution.applied.force.x(), 0.5 * pull, 1e-9 * pull);
      EXPECT_LT(solution.imbalance, 1e-9);
      const auto beams = recover_stresses(model, solution.displacements, load.field())[0].beams;
      for (const int cell : {0, 20, 39}) {
        const double x = cell / 40.0, expected = 0.5 * pull * (1.0 - x * x);
        EXPECT_NEAR(beams[static_cast<std::size_t>(cell)].ends[0][0], expected, 1e-3 * pull);
      }
      EXPECT_NEAR(beams.back().ends[1][0], 0.0, 1e-9 * pull);
    }
}

TEST(Rotation, PullsAMassOnARigidArmAtItsOwnPlace) {
  auto model = blade(2);
  const Index tip = add_node(model.mesh, {1.5, 0.0, 0.0});
  model.links.push_back({"arm", 2, {tip}});
  model.masses.push_back({.name = "tip", .node = tip, .mass = 2.0});
  const double speed = 10.0, of_beam = 0.5 * steel.density * 1e-4 * speed * speed;
  const auto solution = solve_statics(model, turning(speed));
  EXPECT_NEAR(solution.applied.force.x(), of_beam + 2.0 * 1.5 * speed * speed, 1e-9 * of_beam);
  EXPECT_NEAR(solution.reaction_sum.force.x(), -solution.applied.force.x(), 1e-9 * of_beam);
}

TEST(Rotation, AddsToGravity) {
  const LoadCase both{.name = "both", .gravity = {0.0, 0.0, -9.81}, .rotation = Rotation{{0, 0, 1}, {1, 0, 0}, 2.0}};
  EXPECT_LT((both.field().at({3.0, 1.0, 5.0}) - Vector3d(8.0, 4.0, -9.81)).norm(), 1e-14);
}

// Wright, Smith, Thresher and Wang, J. Appl. Mech. 49 (1982) 197-202, uniform cantilever without a hub: first flapping
// frequencies over sqrt(E I / rho A L^4) at the speeds eta in the same unit. In the plane of rotation the same beam has
// sqrt(flap^2 - eta^2).
struct Speed {
  double eta, flap;
};
constexpr std::array<Speed, 7> table = {
    {{0.0, 3.5160}, {2.0, 4.1373}, {4.0, 5.5850}, {6.0, 7.3604}, {8.0, 9.2568}, {10.0, 11.2023}, {12.0, 13.1702}}};

TEST(Rotation, BladeOfBeamsHasItsPublishedFrequencies) {
  const double unit = unit_frequency(0.005);
  double worst = 0.0;
  for (const auto& [eta, flap] : table) {
    const double found = 2.0 * std::numbers::pi * preloaded_frequencies(blade(20), turning(eta * unit), 1)[0] / unit;
    worst = std::max(worst, std::abs(found / flap - 1.0));
    EXPECT_NEAR(found, flap, 0.01 * flap) << eta;
  }
  expect_figure("static.blade.flap", worst);
}

TEST(Rotation, SoftensMotionInItsPlane) {
  const double unit = unit_frequency(0.005);
  double worst = 0.0;
  for (const auto& [eta, flap] : table) {  // about y the soft direction z lies in the plane of rotation
    const double found =
        2.0 * std::numbers::pi * preloaded_frequencies(blade(20), turning(eta * unit, Vector3d::UnitY()), 1)[0] / unit;
    const double lag = std::sqrt(flap * flap - eta * eta);
    worst = std::max(worst, std::abs(found / lag - 1.0));
    EXPECT_NEAR(found, lag, 0.01 * lag) << eta;
  }
  expect_figure("static.blade.lag", worst);
}

// As a strip of shells, narrow so that it bends as a beam does.
TEST(Rotation, BladeOfShellsHasItsPublishedFrequencies) {
  const double thickness = 0.005, unit = unit_frequency(thickness);
  IsotropicMaterial material = steel;
  material.poissons_ratio = 0.0;
  double worst = 0.0;
  for (const auto shape : {CellShape::quadrilateral4, CellShape::triangle3}) {
    ShellProblem strip(
        {40, 2, shape},
        [](double u, double v) -> Vector3d {
          return {u, 0.04 * (v - 0.5), 0.0};
        },
        material, thickness);
    strip.fix(strip.grid.side('u', 0), {0, 1, 2, 3, 4, 5});
    for (const auto& [eta, flap] : table) {
      const double found =
          2.0 * std::numbers::pi * preloaded_frequencies(strip.model, turning(eta * unit), 1)[0] / unit;
      worst = std::max(worst, std::abs(found / flap - 1.0));
      EXPECT_NEAR(found, flap, 0.01 * flap) << eta;
    }
  }
  expect_figure("static.blade.shells", worst);
}

// A point mass on a bar at rest relative to turning axes: (k - m W^2) decides, so speed alone makes it unstable.
TEST(Rotation, BeyondItsCriticalSpeedAStructureIsUnstable) {
  auto model = model_of({});
  const Index node = add_node(model.mesh, Vector3d::Zero());
  model.masses.push_back({.name = "disc", .node = node, .mass = 2.0});
  for (int direction = 0; direction < 3; ++direction)
    model.springs.push_back({.name = "k" + std::to_string(direction), .from = {node, direction}, .stiffness = 800.0});
  model.fixed = {{"no turns", {node}, {false, false, false, true, true, true}}};
  const auto slow = preloaded_frequencies(model, turning(12.0), 3);
  EXPECT_NEAR(slow[0], std::sqrt(400.0 - 144.0) / (2.0 * std::numbers::pi), 1e-9);
  EXPECT_NEAR(slow[2], 20.0 / (2.0 * std::numbers::pi), 1e-9);  // along the axis
  EXPECT_EQ(preloaded_frequencies(model, turning(21.0), 3).size(), 0);
}

}  // namespace
}  // namespace kalfem::test
