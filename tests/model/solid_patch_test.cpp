// SPDX-License-Identifier: Apache-2.0
// The patch of seven hexahedra of MacNeal and Harder [MH85], a unit cube about one of no parallel sides, E = 1e6 and
// nu = 0.25, with its outer corners moved by 1e-3 [2x + y + z, x + 2y + z, x + y + 2z] / 2: 2000 in x, y and z and 400
// in shear everywhere. At corners of it the Jacobian is not positive; at the integration points it is.
#include <gtest/gtest.h>

#include "kalfem/model/checks/model_check.hpp"
#include "kalfem/model/statics/statics.hpp"
#include "kalfem/model/statics/stresses.hpp"
#include "model/fe_models.hpp"
#include "model/solid_models.hpp"

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Severity = FindingSeverity;

Vector3d moved(const Vector3d& x) {
  return 5e-4 * Vector3d(2.0 * x.x() + x.y() + x.z(), x.x() + 2.0 * x.y() + x.z(), x.x() + x.y() + 2.0 * x.z());
}

FiniteElementModel patch(SolidKind kind) {
  auto model = model_of({});
  model.materials["steel"] = {.youngs_modulus = 1e6, .poissons_ratio = 0.25, .density = 1.0};
  model.mesh.source = "patch";
  const std::vector<Vector3d> inner = {{0.249, 0.342, 0.192}, {0.826, 0.288, 0.288}, {0.850, 0.649, 0.263},
                                       {0.273, 0.750, 0.230}, {0.320, 0.186, 0.643}, {0.677, 0.305, 0.683},
                                       {0.788, 0.693, 0.644}, {0.165, 0.745, 0.702}};
  for (const auto& place : inner) add_node(model.mesh, place);
  for (const auto& place :
       std::vector<Vector3d>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}})
    add_node(model.mesh, place);
  for (const auto& nodes : std::vector<std::vector<Index>>{{0, 1, 2, 3, 4, 5, 6, 7},
                                                           {8, 9, 10, 11, 0, 1, 2, 3},
                                                           {4, 5, 6, 7, 12, 13, 14, 15},
                                                           {8, 9, 1, 0, 12, 13, 5, 4},
                                                           {9, 10, 2, 1, 13, 14, 6, 5},
                                                           {10, 11, 3, 2, 14, 15, 7, 6},
                                                           {11, 8, 0, 3, 15, 12, 4, 7}})
    add_cell(model.mesh, "patch", CellShape::hexahedron8, nodes);
  model.properties["patch"] = SolidProperty{"steel", kind};
  return model;
}

TEST(SolidPatch, MacNealAndHardersPatchIsExact) {
  for (const auto kind : solid_kinds) {
    const auto model = patch(kind);
    LoadCase load{.name = "moved"};
    for (Index node = 8; node < 16; ++node)
      for (int axis = 0; axis < 3; ++axis)
        load.imposed.push_back({{node, axis}, moved(model.mesh.nodes.col(node))[axis]});
    const auto solution = solve_statics(model, load);
    for (Index node = 0; node < 8; ++node)
      EXPECT_LT((solution.displacements.segment<3>(6 * node) - moved(model.mesh.nodes.col(node))).norm(), 1e-12)
          << name_of(kind);
    const auto regions = recover_stresses(model, solution.displacements);
    for (const auto& cell : regions[0].cells)
      EXPECT_LT((cell.layers[0].centre - (Stress() << 2000, 2000, 2000, 400, 400, 400).finished()).norm(), 1e-6)
          << name_of(kind);
  }
}

// A corner pushed through its cell, so little that the integration points do not notice: a warning, no refusal.
TEST(SolidPatch, AFoldedCornerIsAWarning) {
  auto model = model_of({});
  for (Index i = 0; i < 8; ++i) add_node(model.mesh, natural_nodes(CellShape::hexahedron8).col(i));
  model.mesh.nodes.col(6).setConstant(0.3);
  add_cell(model.mesh, "cell", CellShape::hexahedron8, {0, 1, 2, 3, 4, 5, 6, 7});
  model.properties["cell"] = SolidProperty{"steel"};
  const auto report = check_model(model, assemble(model), {});
  EXPECT_EQ(report.count(Severity::error), 0);
  EXPECT_TRUE(std::ranges::any_of(report.findings, [](const ModelFinding& finding) {
    return finding.severity == Severity::warning && finding.what.find("scaled Jacobian") != std::string::npos;
  }));
}

}  // namespace
}  // namespace kalfem::test
