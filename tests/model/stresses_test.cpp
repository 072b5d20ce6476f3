// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "kalfem/model/elements/solid.hpp"
#include "kalfem/model/statics/statics.hpp"
#include "kalfem/model/statics/stresses.hpp"
#include "model/element_helpers.hpp"
#include "model/fe_models.hpp"
#include "model/plate_patch.hpp"
#include "model/shell_models.hpp"
#include "model/solid_models.hpp"

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Displacement gradient of a constant strain with a rotation.
const Matrix3d gradient = (Matrix3d() << 1.0, 0.4, -0.3, -0.2, -0.7, 0.5, 0.6, 0.1, 0.3).finished() * 1e-4;

/// A gradient's stress in an isotropic material.
Stress stress_of(const Matrix3d& slope, const IsotropicMaterial& material) {
  const Matrix3d strain = 0.5 * (slope + slope.transpose());
  const Strain engineering =
      (Strain() << strain.diagonal(), 2.0 * strain(0, 1), 2.0 * strain(1, 2), 2.0 * strain(0, 2)).finished();
  return material.youngs_modulus * isotropic_elasticity(material.poissons_ratio) * engineering;
}

double relative_error(const Stress& found, const Stress& expected) {
  return (found - expected).norm() / expected.norm();
}

// Only the outer nodes are moved: the stress inside follows from equilibrium.
TEST(StressPatch, ConstantStressOfDistortedSolidsIsExactEverywhere) {
  for (const auto shape : solid_shapes)
    for (const auto kind : solid_kinds) {
      const SolidProblem problem(
          {3, 3, 2, shape, 0.15},
          [](const Vector3d& cube) -> Vector3d {
            return {2.0 * cube.x(), cube.y() + 0.2 * cube.x(), 0.7 * cube.z()};
          },
          steel, kind);
      LoadCase patch{.name = "patch"};
      for (Index node = 0; node < problem.box.cube.cols(); ++node) {
        const Vector3d cube = problem.box.cube.col(node);
        if (((cube.array() > 1e-9) && (cube.array() < 1.0 - 1e-9)).all()) continue;
        const Vector3d moved = gradient * problem.model.mesh.nodes.col(node);
        for (int direction = 0; direction < 3; ++direction)
          patch.imposed.push_back({{node, direction}, moved[direction]});
      }
      const auto solution = solve_statics(problem.model, patch);
      const Stress expected = stress_of(gradient, steel);
      for (const auto& region : recover_stresses(problem.model, solution.displacements)) {
        for (const auto& cell : region.cells) {
          EXPECT_LT(relative_error(cell.layers[0].centre, expected), 1e-9) << name_of(shape) << " " << name_of(kind);
          for (const auto& at_node : cell.layers[0].at_nodes.colwise())
            EXPECT_LT(relative_error(at_node, expected), 1e-9) << name_of(shape) << " " << name_of(kind);
        }
        for (const auto& mean : nodal_stresses(problem.model.mesh, region))
          EXPECT_LT(relative_error(mean.stress, expected), 1e-9);
      }
    }
}

TEST(StressPatch, ConstantStressOfDistortedShellsIsExactInEveryLayer) {
  for (const auto shape : {CellShape::triangle3, CellShape::quadrilateral4})
    for (const double offset : {0.0, 0.01}) {
      const PlatePatch patch{.e = {1e-4, -3e-5, 5e-5}, .k = {2e-2, -1e-2, 1.5e-2}, .offset = offset};
      const double t = 0.02;
      ShellProblem problem(
          {3, 3, shape, true}, [&](double u, double v) -> Vector3d { return patch.turn * Vector3d(u, 0.8 * v, 0.0); },
          steel, t);
      std::get<ShellProperty>(problem.model.properties.at("shell")).offset = offset;
      VectorXd displacements(6 * problem.grid.mesh.node_count());
      for (Index node = 0; node < problem.grid.mesh.node_count(); ++node) {
        const Vector3d flat = patch.turn.transpose() * problem.grid.mesh.nodes.col(node);
        displacements.segment<6>(6 * node) = patch.motions(flat.x(), flat.y());
      }
      const auto regions = recover_stresses(problem.model, displacements);
      ASSERT_EQ(regions.size(), 1u);
      for (const auto& cell : regions[0].cells)
        for (const auto& [layer, height] :
             {std::pair{Layer::top, 0.5 * t}, {Layer::middle, 0.0}, {Layer::bottom, -0.5 * t}}) {
          const Vector3d plane = steel.youngs_modulus / (1.0 - 0.09) *
                                 (Matrix3d() << 1.0, 0.3, 0.0, 0.3, 1.0, 0.0, 0.0, 0.0, 0.35).finished() *
                                 (patch.e + height * patch.k);
          Matrix3d tensor = Matrix3d::Zero();
          tensor.topLeftCorner<2, 2>() << plane[0], plane[2], plane[2], plane[1];
          tensor = patch.turn * tensor * patch.turn.transpose();
          const Stress expected = (Stress() << tensor.diagonal(), tensor(0, 1), tensor(1, 2), tensor(0, 2)).finished();
          const auto found = std::ranges::find(cell.layers, layer, &LayerStress::layer);
          ASSERT_NE(found, cell.layers.end());
          EXPECT_LT(relative_error(found->centre, expected), 1e-9) << to_string(shape) << to_string(layer);
          for (const auto& at_node : found->at_nodes.colwise()) EXPECT_LT(relative_error(at_node, expected), 1e-9);
        }
      for (const auto& resultants : regions[0].resultants)  // a constant moment has no shear force
        EXPECT_LT(resultants.values.tail<2>().norm(), 1e-9 * resultants.values.segment<3>(3).norm());
    }
}

TEST(StressPatch, StrainOfAShellIncludesThatAcrossIt) {
  ShellProblem problem(
      {1, 1, CellShape::quadrilateral4},
      [](double u, double v) -> Vector3d {
        return {u, v, 0.0};
      },
      steel, 0.01);
  VectorXd displacements = VectorXd::Zero(24);
  for (const Index node : problem.grid.side('u', 1)) displacements[6 * node] = 1e-3;
  const auto& layer = recover_stresses(problem.model, displacements)[0].cells[0].layers[1];
  // Stretched along x, held along y: sigma = E / (1 - nu^2) [1, nu], and plane stress across.
  const double stiff = 2.1e11 / 0.91;
  EXPECT_NEAR(layer.centre[0], 1e-3 * stiff, 1.0);
  EXPECT_NEAR(layer.centre[1], 0.3e-3 * stiff, 1.0);
  const Strain elastic = (2.1e11 * isotropic_elasticity(0.3)).inverse() * layer.centre;
  EXPECT_LT((layer.strain - elastic).norm(), 1e-12);
}

/// Largest difference of the nodal stress from E k y under bending in the plane, relative to its largest value.
double in_plane_bending_error(const Cut& cut) {
  ShellProblem problem(
      cut,
      [](double u, double v) -> Vector3d {
        return {4.0 * u, v - 0.5, 0.0};
      },
      steel, 0.1);
  const double curvature = 1e-5;  // u = -k x y, v = k (x^2 + nu y^2) / 2, turn k x
  VectorXd displacements = VectorXd::Zero(6 * problem.grid.mesh.node_count());
  for (Index node = 0; node < problem.grid.mesh.node_count(); ++node) {
    const Vector3d x = problem.grid.mesh.nodes.col(node);
    displacements[6 * node] = -curvature * x.x() * x.y();
    displacements[6 * node + 1] = 0.5 * curvature * (x.x() * x.x() + 0.3 * x.y() * x.y());
    displacements[6 * node + 5] = curvature * x.x();
  }
  const auto region = recover_stresses(problem.model, displacements)[0];
  double error = 0.0;
  for (const auto& mean : nodal_stresses(problem.model.mesh, region))
    if (mean.layer == Layer::middle)
      error = std::max(error, std::abs(mean.stress[0] / (2.1e11 * curvature) + problem.model.mesh.nodes(1, mean.node)));
  return error / 0.5;
}

// The enhanced strains make a row of quadrilaterals exact; triangles converge with the second order or better inside
// and the first at the edges.
TEST(Stresses, BendingInThePlaneOfShells) {
  EXPECT_LT(in_plane_bending_error({4, 1, CellShape::quadrilateral4}), 1e-9);
  const double coarse = in_plane_bending_error({16, 4, CellShape::triangle3});
  const double fine = in_plane_bending_error({32, 8, CellShape::triangle3});
  EXPECT_LT(coarse, 0.2);
  EXPECT_LT(fine, 0.55 * coarse);
}

TEST(Stresses, VonMisesAndPrincipalStresses) {
  const Stress uniaxial = (Stress() << 100.0, 0.0, 0.0, 0.0, 0.0, 0.0).finished();
  const Stress shear = (Stress() << 0.0, 0.0, 0.0, 40.0, 0.0, 0.0).finished();
  const Stress pressure = (Stress() << -5.0, -5.0, -5.0, 0.0, 0.0, 0.0).finished();
  EXPECT_DOUBLE_EQ(von_mises(uniaxial), 100.0);
  EXPECT_DOUBLE_EQ(von_mises(shear), 40.0 * std::sqrt(3.0));
  EXPECT_DOUBLE_EQ(von_mises(pressure), 0.0);
  EXPECT_LT((principal_stresses(shear) - Vector3d(40.0, 0.0, -40.0)).norm(), 1e-12);
}

// A tube of square section along z: at its edges the four sides keep their own stress, and normals that point the other
// way do not swap the surfaces.
TEST(Stresses, NodalMeansDoNotMixSurfacesThatMeetAtAnEdge) {
  Mesh mesh;
  for (const auto& place : {Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(1, 1, 0), Vector3d(0, 0, 1),
                            Vector3d(1, 0, 1), Vector3d(1, 1, 1)})
    add_node(mesh, place);
  add_cell(mesh, "wall", CellShape::quadrilateral4, {0, 1, 4, 3});
  add_cell(mesh, "wall", CellShape::quadrilateral4, {1, 2, 5, 4});
  auto model = model_of(mesh);
  model.properties["wall"] = ShellProperty{"steel", 0.01};
  VectorXd displacements = VectorXd::Zero(36);
  for (const Index node : {0, 3}) displacements[6 * node] = -1e-3;  // only the first side is stretched
  const auto regions = recover_stresses(model, displacements);
  int at_edge = 0;
  for (const auto& mean : nodal_stresses(model.mesh, regions[0]))
    if (mean.node == 1 && mean.layer == Layer::middle) {
      ++at_edge;
      EXPECT_TRUE(std::abs(mean.stress[0]) < 1e-3 || std::abs(mean.stress[0] - 1e-3 * 2.1e11 / 0.91) < 1e-3 * 2.1e11);
    }
  EXPECT_EQ(at_edge, 2);
}

}  // namespace
}  // namespace kalfem::test
