// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/placement.hpp"

#include <gtest/gtest.h>

#include "kalfem/model/checks/model_check.hpp"
#include "kalfem/model/mesh/laminate_theory.hpp"
#include "kalfem/model/statics/statics.hpp"
#include "model/beam_models.hpp"

// A model that is turned and moved as one body is the same structure: frequencies stay, K becomes R K R^T, and what a
// load case moves is turned.

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

const Placement askew{
    .rotation = turn_about({1.0, 2.0, -0.5}, 0.7), .about = {0.3, -1.0, 2.0}, .shift = {5.0, 0.0, 1.0}};

FiniteElementModel placed(FiniteElementModel model, const Placement& placement = askew) {
  std::vector<LoadCase> none;
  place(model, none, placement);
  return model;
}

FixedNodes held(const std::string& name, std::vector<Index> nodes, const std::vector<int>& directions) {
  FixedNodes fixed{name, std::move(nodes), {}};
  fixed.directions.fill(false);
  for (const int direction : directions) fixed.directions[static_cast<std::size_t>(direction)] = true;
  return fixed;
}

/// Every kind of element: a beam with an offset and an orientation, a laminate, a solid with a stiff direction; a body
/// off its node.
FiniteElementModel elements() {
  Mesh mesh = line_mesh({0.0, 0.0, 0.0}, {2.0, 0.0, 0.0}, 2);
  for (const auto& place : {Vector3d(0, 1, 0), Vector3d(1, 1, 0), Vector3d(1, 2, 0), Vector3d(0, 2, 0)})
    add_node(mesh, place);
  for (const double z : {1.0, 2.0})
    for (const auto& place : {Vector3d(0, 0, z), Vector3d(1, 0, z), Vector3d(1.1, 1, z), Vector3d(0, 1, z)})
      add_node(mesh, place);
  add_cell(mesh, "skin", CellShape::quadrilateral4, {3, 4, 5, 6});
  add_cell(mesh, "block", CellShape::hexahedron8, {7, 8, 9, 10, 11, 12, 13, 14});
  auto model = model_of(mesh);
  model.properties["line"] =
      beam_property(rectangular_section(0.02, 0.05), Vector3d(0.0, 0.03, 0.01), Vector3d(0.0, 1.0, 2.0));
  const OrthotropicSheet sheet{1.4e11, 1e10, 0.3, 5e9, 5e9, 3e9, 1600.0};
  auto laminate = laminated({{sheet, 0.004, 0.0}, {sheet, 0.002, 0.5}}, 0.0);
  laminate.directions = {Vector3d(1.0, 0.3, 0.0)};
  model.properties["skin"] = laminate;
  Matrix6 elasticity = 1e10 * Matrix6::Identity();
  elasticity(0, 0) = 9e10;
  elasticity(0, 1) = elasticity(1, 0) = 4e9;
  model.properties["block"] = SolidProperty{"steel", SolidKind::standard, elasticity};
  PointMass body{.name = "body", .node = 2, .mass = 3.0, .offset = {0.1, 0.2, -0.1}};
  body.inertia.diagonal() << 0.1, 0.2, 0.25;
  model.masses = {body};
  return model;
}

/// R of every block of three degrees of freedom.
MatrixXd turn_of(const AssembledModel& assembled, const Matrix3d& rotation) {
  MatrixXd turn = MatrixXd::Zero(assembled.size(), assembled.size());
  for (Index i = 0; i < assembled.size(); i += 3) turn.block<3, 3>(i, i) = rotation;
  return turn;
}

TEST(Placement, TurnsStiffnessAndMass) {
  const auto before = assemble(elements()), after = assemble(placed(elements()));
  ASSERT_EQ(after.dofs, before.dofs);
  const MatrixXd turn = turn_of(before, askew.rotation);
  EXPECT_LT(difference(stiffness_of(after), turn * stiffness_of(before) * turn.transpose()), 1e-10);
  EXPECT_LT(difference(mass_of(after), turn * mass_of(before) * turn.transpose()), 1e-10);
  EXPECT_GT(difference(stiffness_of(after), stiffness_of(before)), 0.1);
}

/// A beam along x, 2 m of four elements, with everything that names single directions: a roller, springs to the ground
/// and between nodes, a joint, a constraint, links that tie some directions, and matrices of one.
FiniteElementModel directions() {
  auto model = beam_model({2.0, 0.0, 0.0}, 4, rectangular_section(0.02, 0.05));
  const Index hung = add_node(model.mesh, {2.0, 0.5, 0.0}), mean = add_node(model.mesh, {1.0, 0.0, 0.3}),
              alone = add_node(model.mesh, {0.0, 0.0, 1.0});
  model.fixed = {held("wall", {0}, {0, 1, 2, 3, 4, 5}), held("roller", {4}, {2})};
  model.springs = {{"soil", {2, 1}, {}, "ground", 1e5, 3.0}, {"strut", {3, 1}, NodalDof{1, 2}, "", 2e5, 0.0}};
  model.joints = {{"oblique", {{{2, 0}, 0.6}, {{2, 2}, 0.8}, {{1, 1}, -0.5}}, 3e5, 0.0}};
  model.masses = {{"hung", hung, 2.0}, {"mean", mean, 1.0}, {"alone", alone, 1.5}};
  model.links = {{"pin", 3, {hung}, {true, true, true, true, false, false}}};
  model.weighted_links = {
      {"mean",
       mean,
       {true, true, true, false, false, false},
       {{1, 1.0, {true, true, true, false, true, true}}, {2, 2.0, {true, true, true, true, false, false}}}}};
  model.constraints = {{"gear", {{{alone, 0}, 1.0}, {{2, 2}, 0.5}, {{3, 5}, -0.2}}}};
  NodalMatrices guide{"guide", {{alone, 1}, {alone, 2}}, {}, {}, {}};
  guide.stiffness = MatrixXd(Eigen::Matrix2d{{2e4, -5e3}, {-5e3, 1e4}}).sparseView();
  model.matrices = {guide};
  model.joints.push_back({"swivel", {{{hung, 4}, 1.0}}, 1e3, 0.0});
  model.joints.push_back({"swivel2", {{{hung, 5}, 1.0}}, 1e3, 0.0});
  return model;
}

TEST(Placement, KeepsFrequenciesWhereSingleDirectionsAreNamed) {
  const Eigen::VectorXd before = frequencies(directions(), 12), after = frequencies(placed(directions()), 12);
  EXPECT_GT(before[0], 1.0);
  EXPECT_LT((after - before).cwiseQuotient(before).cwiseAbs().maxCoeff(), 1e-8) << before.transpose() << "\n"
                                                                                << after.transpose();
  const Placement twice{.rotation = turn_about({0.0, 1.0, 0.0}, -1.1)};
  const Eigen::VectorXd again = frequencies(placed(placed(directions()), twice), 12);
  EXPECT_LT((again - before).cwiseQuotient(before).cwiseAbs().maxCoeff(), 1e-8);
}

TEST(Placement, MovesMassProperties) {
  const auto before = mass_properties(assemble(directions())), after = mass_properties(assemble(placed(directions())));
  EXPECT_NEAR(after.mass, before.mass, 1e-12 * before.mass);
  EXPECT_LT((after.centre - askew.at(before.centre)).norm(), 1e-12);
  EXPECT_LT(difference(after.inertia, askew.rotation * before.inertia * askew.rotation.transpose()), 1e-10);
}

const Reaction& reaction(const StaticSolution& solution, const std::string& name) {
  const auto found = std::ranges::find(solution.reactions, name, &Reaction::name);
  EXPECT_NE(found, solution.reactions.end()) << name;
  return *found;
}

/// Forces, moments, gravity and a rotation; the roller is moved along its own direction, another node along y.
TEST(Placement, TurnsWhatLoadCasesDo) {
  auto model = beam_model({2.0, 0.0, 0.0}, 4, rectangular_section(0.02, 0.05));
  model.fixed = {held("wall", {0}, {0, 1, 2, 3, 4, 5}), held("roller", {4}, {2})};
  const LoadCase given{.name = "all",
                       .loads = {{2, {10.0, -20.0, 5.0}, {1.0, 2.0, 3.0}}},
                       .gravity = {0.0, -3.0, -9.81},
                       .rotation = Rotation{{0.0, 1.0, 1.0}, {1.0, 0.0, 0.0}, 20.0},
                       .imposed = {{{4, 2}, 0.01, true}, {{3, 1}, -0.004, false}}};
  std::vector<LoadCase> cases{given};
  auto turned = model;
  place(turned, cases, askew);
  const auto before = solve_statics(model, given), after = solve_statics(turned, cases[0]);
  const double largest = before.displacements.cwiseAbs().maxCoeff();
  EXPECT_NEAR(before.displacements[6 * 4 + 2], 0.01, 1e-15);
  for (Index node = 0; node < model.mesh.node_count(); ++node)
    for (const Index block : {0, 3})
      EXPECT_LT((after.displacements.segment<3>(6 * node + block) -
                 askew.rotation * before.displacements.segment<3>(6 * node + block))
                    .norm(),
                1e-9 * largest);
  for (const char* name : {"wall", "roller", "imposed motion"}) {
    const Resultant &own = reaction(before, name).sum, &other = reaction(after, name).sum;
    EXPECT_LT((other.force - askew.rotation * own.force).norm(), 1e-7 * own.force.norm()) << name;
  }
  EXPECT_LT(before.imbalance, 1e-9);
  EXPECT_LT(after.imbalance, 1e-9);
}

/// A free body is told to be free along its own axes, and a roller on a slope holds across it.
TEST(Placement, RollerOnASlopeHoldsAcrossIt) {
  auto model = beam_model({2.0, 0.0, 0.0}, 2, rectangular_section(0.02, 0.05));
  model.fixed = {held("pin", {0}, {0, 1, 2, 3, 5}), held("roller", {2}, {2})};
  const auto slope = placed(model, {.rotation = turn_about({0.0, 1.0, 0.0}, -std::numbers::pi / 6.0)});
  const double force = 100.0;
  const auto solution = solve_statics(slope, {.name = "f", .loads = {{1, {0.0, 0.0, -force}, Vector3d::Zero()}}});
  const Vector3d across(-0.5, 0.0, std::sqrt(0.75));
  // Moments about the pin: the roller takes half of the load's component across the slope.
  const Vector3d expected = 0.5 * force * std::sqrt(0.75) * across;
  EXPECT_LT((reaction(solution, "roller").sum.force - expected).norm(), 1e-9 * force);
  EXPECT_LT(solution.imbalance, 1e-9);
}

TEST(Placement, IsNoFindingOfTheModelCheck) {
  const auto count = [](const FiniteElementModel& model) {
    const auto report = check_model(model, assemble(model));
    return std::pair(report.count(FindingSeverity::error), report.count(FindingSeverity::warning));
  };
  EXPECT_EQ(count(placed(directions())), count(directions()));
}

TEST(Placement, WithoutATurnAddsNothing) {
  const auto moved = placed(directions(), {.shift = {1.0, 2.0, 3.0}});
  EXPECT_EQ(moved.mesh.node_count(), directions().mesh.node_count());
  EXPECT_EQ(moved.mesh.nodes, MatrixXd(directions().mesh.nodes.colwise() + Vector3d(1.0, 2.0, 3.0)));
  EXPECT_EQ(moved.links.size(), 1u);
}

/// A generalised coordinate is no motion along a direction.
TEST(Placement, LeavesScalarPointsAlone) {
  auto model = beam_model({1.0, 0.0, 0.0}, 1, rectangular_section(0.02, 0.05));
  const Index scalar = add_node(model.mesh, Vector3d::Zero());
  model.mesh.node_sets[scalar_points] = {scalar};
  model.springs = {{"modal", {scalar, 0}, {}, "ground", 5.0, 0.0}};
  const auto turned = placed(model);
  EXPECT_EQ(turned.springs[0].from, (NodalDof{scalar, 0}));
  EXPECT_EQ(turned.mesh.node_count(), model.mesh.node_count());
}

TEST(Placement, ContradictionsAreStillTold) {
  auto model = beam_model({2.0, 0.0, 0.0}, 2, rectangular_section(0.02, 0.05));
  model.links = {{"arm", 0, {2}}};
  model.fixed = {held("roller", {2}, {2})};
  EXPECT_NE(issues_of(model).find("n3.z is fixed and follows from 'arm'"), std::string::npos) << issues_of(model);
  const auto turned = issues_of(placed(model));
  EXPECT_NE(turned.find("is fixed and follows from 'axes.n4.z'"), std::string::npos) << turned;
}

TEST(Placement, TurnsByTheRightHandRule) {
  const Matrix3d quarter = turn_about({0.0, 0.0, 5.0}, std::numbers::pi / 2.0);
  EXPECT_EQ(Vector3d(quarter * Vector3d::UnitX()), Vector3d::UnitY());
  EXPECT_LT((askew.rotation * askew.rotation.transpose() - Matrix3d::Identity()).norm(), 1e-15);
}

}  // namespace
}  // namespace kalfem::test
