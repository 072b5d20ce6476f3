// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kalfem/model/gauges/nearest_place.hpp"
#include "kalfem/model/gauges/strain_gauge.hpp"
#include "kalfem/model/statics/statics.hpp"
#include "model/beam_models.hpp"
#include "model/plate_patch.hpp"
#include "model/shell_models.hpp"
#include "model/solid_models.hpp"

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::HasSubstr;

double strain_under(const FiniteElementModel& model, const StrainGauge& gauge, const VectorXd& displacements) {
  double strain = 0.0;
  for (const auto& [dof, coefficient] : strain_row(model, gauge))
    strain += coefficient * displacements[6 * dof.node + dof.direction];
  return strain;
}

/// A place inside the cell that is not its centre.
Vector3d some_place(CellShape shape) { return 0.6 * natural_centre(shape) + Vector3d(0.11, 0.07, 0.13); }

const std::vector<Vector3d> directions = {{1.0, 0.0, 0.0}, {0.3, -0.5, 0.8}, {-2.0, 1.0, 0.4}};

TEST(StrainGauge, ConstantStrainOfDistortedSolidsIsExact) {
  const Matrix3d gradient = (Matrix3d() << 1.0, 0.4, -0.3, -0.2, -0.7, 0.5, 0.6, 0.1, 0.3).finished() * 1e-4;
  for (const auto shape : solid_shapes)
    for (const auto kind : solid_kinds) {
      const SolidProblem problem(
          {3, 3, 2, shape, 0.15},
          [](const Vector3d& cube) -> Vector3d {
            return {2.0 * cube.x(), cube.y() + 0.2 * cube.x(), 0.7 * cube.z()};
          },
          steel, kind);
      const auto& mesh = problem.model.mesh;
      VectorXd displacements = VectorXd::Zero(6 * mesh.node_count());
      for (Index node = 0; node < mesh.node_count(); ++node)
        displacements.segment<3>(6 * node) = gradient * mesh.nodes.col(node);
      for (Index cell = 0; cell < std::ssize(mesh.cells); cell += 7)
        for (const auto& direction : directions) {
          const Vector3d d = direction.normalized();
          const StrainGauge gauge{.name = "g", .cell = cell, .natural = some_place(shape), .direction = direction};
          EXPECT_NEAR(strain_under(problem.model, gauge, displacements), d.dot(gradient * d), 1e-13)
              << name_of(shape) << " " << name_of(kind);
        }
    }
}

TEST(StrainGauge, ConstantStrainAndCurvatureOfDistortedShellsIsExactOnBothSides) {
  const double t = 0.02;
  for (const auto shape : {CellShape::triangle3, CellShape::quadrilateral4})
    for (const double offset : {0.0, 0.01}) {
      const PlatePatch patch{.e = {1e-4, -3e-5, 5e-5}, .k = {2e-2, -1e-2, 1.5e-2}, .offset = offset};
      ShellProblem problem(
          {3, 3, shape, true}, [&](double u, double v) -> Vector3d { return patch.turn * Vector3d(u, 0.8 * v, 0.0); },
          steel, t);
      std::get<ShellProperty>(problem.model.properties.at("shell")).offset = offset;
      const auto& mesh = problem.model.mesh;
      VectorXd displacements(6 * mesh.node_count());
      for (Index node = 0; node < mesh.node_count(); ++node) {
        const Vector3d flat = patch.turn.transpose() * mesh.nodes.col(node);
        displacements.segment<6>(6 * node) = patch.motions(flat.x(), flat.y());
      }
      for (const auto& [surface, height] :
           {std::pair{Layer::top, 0.5 * t}, {Layer::middle, 0.0}, {Layer::bottom, -0.5 * t}}) {
        const Vector3d plane = patch.e + height * patch.k;
        const double angle = 0.4, c = std::cos(angle), s = std::sin(angle);
        const double expected = c * c * plane[0] + s * s * plane[1] + c * s * plane[2];
        for (Index cell = 0; cell < std::ssize(mesh.cells); ++cell) {
          const StrainGauge gauge{.name = "g",
                                  .cell = cell,
                                  .natural = some_place(shape),
                                  .direction = patch.turn * Vector3d(c, s, 0.3),  // laid into the surface
                                  .surface = surface};
          EXPECT_NEAR(strain_under(problem.model, gauge, displacements), expected, 1e-13) << to_string(surface);
        }
      }
    }
}

// A clamped beam under a force and a pull at its end: epsilon = N / E A - z F (L - x) / E I about either axis.
TEST(StrainGauge, FibresOfABentBeam) {
  const double length = 1.2, pull = 900.0, force_y = -20.0, force_z = 30.0;
  for (const auto& section : {slender(), rectangular_section(0.02, 0.03)}) {
    auto model = beam_model({length, 0.0, 0.0}, 4, section);
    model.fixed = {{.name = "clamp", .nodes = {0}}};
    LoadCase load{.name = "tip"};
    load.loads = {{.node = 4, .force = {pull, force_y, force_z}}};
    const auto displacements = solve_statics(model, load).displacements;
    for (Index cell = 0; cell < 4; ++cell)
      for (const double r : {-1.0, 0.2, 1.0}) {
        const double x = 0.3 * (static_cast<double>(cell) + 0.5 * (1.0 + r)), arm = length - x;
        const Eigen::Vector2d fibre(0.006, -0.012);
        const StrainGauge gauge{.name = "g", .cell = cell, .natural = {r, 0.0, 0.0}, .fibre = fibre};
        const double expected = pull / (2.1e11 * section.area) -
                                fibre[0] * force_y * arm / (2.1e11 * section.inertia_z) -
                                fibre[1] * force_z * arm / (2.1e11 * section.inertia_y);
        EXPECT_NEAR(strain_under(model, gauge, displacements), expected, 1e-9 * std::abs(expected)) << cell << " " << r;
      }
  }
}

// At the centre of each element of a plate under load, along x, y and between.
TEST(StrainGauge, EqualsTheStrainThatStaticsStates) {
  ShellProblem problem(
      {5, 4, CellShape::quadrilateral4, true},
      [](double u, double v) -> Vector3d {
        return {u, 0.7 * v, 0.1 * u * u};
      },
      steel, 0.01);
  problem.fix(problem.grid.side('u', 0), {0, 1, 2, 3, 4, 5});
  problem.load_area(2, 1e3);
  const VectorXd displacements = solve(problem);
  const auto regions = recover_stresses(problem.model, displacements);
  for (const auto& cell : regions[0].cells)
    for (const auto& layer : cell.layers) {
      const Vector3d tangent =
          (Vector3d(1.0, 0.5, 0.0) - Vector3d(1.0, 0.5, 0.0).dot(cell.normal) * cell.normal).normalized();
      const Strain& e = layer.strain;
      const double expected = tangent.dot(
          (Matrix3d() << e[0], 0.5 * e[3], 0.5 * e[5], 0.5 * e[3], e[1], 0.5 * e[4], 0.5 * e[5], 0.5 * e[4], e[2])
              .finished() *
          tangent);
      const StrainGauge gauge{.name = "g", .cell = cell.cell, .direction = {1.0, 0.5, 0.0}, .surface = layer.layer};
      EXPECT_NEAR(strain_under(problem.model, gauge, displacements), expected, 1e-9 * e.norm());
    }
}

TEST(StrainGauge, RigidMotionStrainsNothing) {
  const auto model = beam_model({0.3, 0.2, -0.1}, 1, rectangular_section(0.02, 0.03));
  const StrainGauge gauge{.name = "g", .cell = 0, .fibre = {0.01, 0.01}};
  const Vector3d shift(0.1, -0.2, 0.3), turn(0.02, 0.01, -0.03);
  VectorXd displacements(12);
  for (Index node = 0; node < 2; ++node)
    displacements.segment<6>(6 * node) << shift + turn.cross(Vector3d(model.mesh.nodes.col(node))), turn;
  EXPECT_NEAR(strain_under(model, gauge, displacements), 0.0, 1e-15);
}

/// A strip of two square plates, the second one tied to node 3 as one rigid body.
FiniteElementModel half_rigid_strip() {
  auto model = model_of(plate_mesh(2.0, 1.0, 2, 1));
  model.properties["plate"] = ShellProperty{"steel", 0.01};
  model.fixed = {{.name = "clamp", .nodes = {0, 3}}};
  model.links = {{.name = "stiff", .master = 2, .slaves = {1, 4, 5}}};
  return model;
}

// Strain of the first plate by the motion of the master alone: it stretches by u_x and bends by its rotation.
TEST(StrainGauge, LinksAndSupportsAreEliminated) {
  const auto model = half_rigid_strip();
  const StrainGauge gauge{.name = "g", .cell = 0, .direction = Vector3d::UnitX(), .surface = Layer::middle};
  const auto combination = gauge_combinations(model, assemble(model), {gauge}).at("g");
  EXPECT_NEAR(combination.at("n3.x"), 1.0, 1e-12);
  for (const auto& [dof, coefficient] : combination) EXPECT_TRUE(dof.starts_with("n3.")) << dof;
}

TEST(StrainGauge, OnARigidPartIsRefused) {
  const auto model = half_rigid_strip();
  const StrainGauge gauge{.name = "g", .cell = 1, .direction = Vector3d::UnitX(), .surface = Layer::top};
  const auto message = message_of([&] { gauge_combinations(model, assemble(model), {gauge}); });
  EXPECT_THAT(message, HasSubstr("strain gauge 'g' stands on element 2, which cannot deform"));
}

TEST(StrainGauge, OfALaminateIsThatOfItsMiddle) {
  auto model = model_of(plate_mesh(1.0, 1.0, 1, 1));
  model.properties["plate"] = LaminateProperty{.stiffness = isotropic_section(0.3, 0.01)};
  StrainGauge gauge{.name = "g", .cell = 0, .direction = Vector3d::UnitX(), .surface = Layer::middle};
  VectorXd displacements = VectorXd::Zero(24);
  for (const Index node : {1, 3}) displacements[6 * node] = 1e-3;
  EXPECT_NEAR(strain_under(model, gauge, displacements), 1e-3, 1e-12);
  gauge.surface = Layer::top;
  EXPECT_THAT(message_of([&] { strain_row(model, gauge); }), HasSubstr("write surface: middle"));
}

}  // namespace
}  // namespace kalfem::test
