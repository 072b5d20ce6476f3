// SPDX-License-Identifier: Apache-2.0
// Motions that links make dependent, chosen as coordinates: the same structure in other coordinates.
#include <gtest/gtest.h>

#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/model/assembly/assembly.hpp"
#include "kalfem/model/assembly/rigid_body.hpp"
#include "kalfem/model/assembly/rigid_motion.hpp"
#include "model/fe_models.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using test::add_node;

/// A clamped plate of 5 x 3 nodes; a hub above its free edge follows the edge's three nodes, or leads them.
struct HubPlate {
  FiniteElementModel model;
  Index hub = 0;
  std::vector<Index> edge = {4, 9, 14};

  HubPlate() {
    Mesh mesh = test::plate_mesh(1.0, 0.4, 4, 2);
    hub = add_node(mesh, {1.1, 0.2, 0.05});
    model = test::model_of(std::move(mesh));
    model.properties["plate"] = ShellProperty{"steel", 0.01};
    model.fixed.push_back({"root", {0, 5, 10}, {true, true, true, true, true, true}});
    model.masses.push_back({.name = "device", .node = hub, .mass = 2.0});
  }

  void follow() {
    model.weighted_links.push_back({"mean", hub, {true, true, true, true, true, true}, {{4}, {14}, {8}}});
  }
  void lead() { model.links.push_back({"rigid", hub, edge}); }
};

VectorXd frequencies(const AssembledModel& assembled) {
  const auto modes = lowest_modes(evaluate(assembled.stiffness, assembled.parameters),
                                  evaluate(assembled.mass, assembled.parameters), {.count = 8});
  return modes.values.cwiseSqrt();
}

std::vector<NodalDof> all_motions(Index node) {
  std::vector<NodalDof> dofs;
  for (int direction = 0; direction < 6; ++direction) dofs.push_back({node, direction});
  return dofs;
}

void expect_same_structure(const FiniteElementModel& model, const std::vector<NodalDof>& independent) {
  const auto usual = assemble(model), turned = assemble(model, {.independent = independent});
  for (const auto& dof : independent) EXPECT_GE(turned.find(dof), 0) << dof.node << "." << dof.direction;
  ASSERT_EQ(turned.size(), usual.size());
  // Coordinates differ, frequencies do not: found 9e-11, rounding times the condition.
  EXPECT_LT((frequencies(turned) - frequencies(usual)).norm(), 1e-9 * frequencies(usual).norm());
  const Eigen::MatrixXd expansion(turned.expansion);
  for (const auto& dof : independent) {
    const auto row = expansion.row(6 * dof.node + dof.direction);
    EXPECT_DOUBLE_EQ(row[turned.find(dof)], 1.0);
    EXPECT_DOUBLE_EQ(row.cwiseAbs().sum(), 1.0);
  }
}

TEST(IndependentMotions, MayBeThoseOfAWeightedMean) {
  HubPlate plate;
  plate.follow();
  ASSERT_LT(assemble(plate.model).find({plate.hub, 2}), 0);
  expect_same_structure(plate.model, {{plate.hub, 0}, {plate.hub, 1}, {plate.hub, 2}});
  expect_same_structure(plate.model, all_motions(plate.hub));
}

TEST(IndependentMotions, MayBeThoseOfARigidLinksFollowers) {
  HubPlate plate;
  plate.lead();
  ASSERT_LT(assemble(plate.model).find({9, 2}), 0);
  expect_same_structure(plate.model, all_motions(9));
  expect_same_structure(plate.model, {{4, 2}, {14, 2}, {9, 0}});
}

/// A chain: the hub is the mean of nodes of which one follows a rigid link, and a constraint follows the hub.
TEST(IndependentMotions, MayStandAtTheEndOfAChain) {
  HubPlate plate;
  plate.follow();
  plate.model.links.push_back({"arm", 13, {14}});
  plate.model.constraints.push_back({"gear", {{{7, 2}, 1.0}, {{plate.hub, 2}, -0.5}}});
  expect_same_structure(plate.model, {{plate.hub, 2}, {14, 2}});
}

TEST(IndependentMotions, ThatFollowFromEachOtherStayDependent) {
  HubPlate plate;
  plate.lead();
  // Seven motions of one rigid body.
  auto motions = all_motions(4);
  motions.push_back({9, 1});
  const auto assembled = assemble(plate.model, {.independent = motions});
  for (int direction = 0; direction < 6; ++direction) EXPECT_GE(assembled.find({4, direction}), 0);
  EXPECT_LT(assembled.find({9, 1}), 0);
  const Eigen::MatrixXd expansion(assembled.expansion);
  // Node 9 lies 0.2 m along y from node 4: both move alike along y.
  EXPECT_NEAR(expansion(6 * 9 + 1, assembled.find({4, 1})), 1.0, 1e-14);  // rounding
}

TEST(IndependentMotions, AreNotFoundWhereTheyAreHeld) {
  HubPlate plate;
  plate.lead();
  plate.model.fixed.push_back({"axle", {plate.hub}, {true, true, true, true, true, true}});
  const auto assembled = assemble(plate.model, {.independent = {{9, 2}, {0, 2}}});
  EXPECT_LT(assembled.find({9, 2}), 0);
  EXPECT_LT(assembled.find({0, 2}), 0);
}

TEST(WholeMass, CountsWhatIsHeldToo) {
  HubPlate plate;
  plate.follow();
  const double shell = 7850.0 * 0.4 * 0.01;
  const auto held = assemble(plate.model);
  const auto whole = mass_properties(held);
  EXPECT_NEAR(whole.mass, shell + 2.0, 2e-13);  // rounding, as of the next
  EXPECT_LT(
      (whole.centre - (shell * Eigen::Vector3d(0.5, 0.2, 0.0) + 2.0 * Eigen::Vector3d(1.1, 0.2, 0.05)) / (shell + 2.0))
          .norm(),
      1e-15);
  // Bilinear shapes of the four columns of elements: a free shape of 1 but at the root carries 1 - 2/3 / 4 of the mass.
  const auto moving = moving_mass(plate.model, held, evaluate(held.mass, held.parameters));
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(moving[axis], shell * (1.0 - 2.0 / 12.0) + 2.0, 2e-13) << axis;
  plate.model.fixed.clear();
  const auto loose = assemble(plate.model);
  const auto all = moving_mass(plate.model, loose, evaluate(loose.mass, loose.parameters));
  EXPECT_LT((all.array() - whole.mass).abs().maxCoeff(), 2e-13);
}

TEST(ElementSizes, AreThoseOfTheElementsAtANode) {
  Mesh mesh = test::plate_mesh(4.0, 3.0, 1, 1);
  const Index lonely = add_node(mesh, {4.0, 3.0, 2.0});
  const std::vector<Index> nodes = {0, lonely};
  const auto sizes = element_sizes(mesh, nodes);
  EXPECT_DOUBLE_EQ(sizes[0], 5.0);  // the diagonal
  EXPECT_DOUBLE_EQ(sizes[1], 2.0);  // to the nearest node
}

}  // namespace
}  // namespace kalfem
