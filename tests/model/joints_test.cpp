// SPDX-License-Identifier: Apache-2.0
// Springs along any deformation, matrices as they are, and nodes that follow the mean motion of others.
#include <gtest/gtest.h>

#include "kalfem/model/assembly/assembly.hpp"
#include "kalfem/model/assembly/constraints.hpp"
#include "kalfem/model/assembly/rigid_body.hpp"
#include "kalfem/model/finite_element_model.hpp"
#include "model/fe_models.hpp"

namespace kalfem {
namespace {

using namespace test;

/// Two nodes with bodies, which nothing joins.
FiniteElementModel two_bodies() {
  Mesh mesh;
  add_node(mesh, {0.0, 0.0, 0.0});
  add_node(mesh, {0.3, 0.4, 0.0});
  auto model = model_of(std::move(mesh));
  for (const Eigen::Index node : {0, 1})
    model.masses.push_back({.name = "body" + std::to_string(node),
                            .node = node,
                            .mass = 2.0 + static_cast<double>(node),
                            .inertia = Eigen::Matrix3d::Identity()});
  return model;
}

TEST(Joints, ObliqueSpringPushesAlongItsAxisOnly) {
  auto model = two_bodies();
  const Eigen::Vector3d axis(0.6, 0.8, 0.0);
  JointSpring joint{.name = "strut", .deformation = {}, .stiffness = 500.0, .damping = 7.0};
  for (int d = 0; d < 3; ++d) {
    joint.deformation.push_back({{1, d}, axis[d]});
    joint.deformation.push_back({{0, d}, -axis[d]});
  }
  model.joints = {joint};
  const auto assembled = assemble(model);
  ASSERT_EQ(assembled.size(), 12);
  Eigen::VectorXd direction(12);
  direction << -axis, 0, 0, 0, axis, 0, 0, 0;
  EXPECT_LT(difference(stiffness_of(assembled), 500.0 * direction * direction.transpose()), 1e-15);  // rounding
  EXPECT_LT(difference(Eigen::MatrixXd(assembled.damping), 7.0 * direction * direction.transpose()), 1e-15);
  EXPECT_EQ(assembled.parameters.at("strut.stiffness"), 500.0);
}

TEST(Joints, MatricesBetweenNodesAddUp) {
  auto sprung = two_bodies(), given = two_bodies();
  NodalSpring spring;
  spring.name = "s";
  spring.from = {0, 1};
  spring.to = NodalDof{1, 4};
  spring.stiffness = 30.0;
  spring.damping = 0.5;
  sprung.springs = {spring};
  Eigen::SparseMatrix<double> unit(2, 2);
  unit.insert(0, 0) = unit.insert(1, 1) = 1.0;
  unit.insert(0, 1) = unit.insert(1, 0) = -1.0;
  given.matrices = {{"s", {{0, 1}, {1, 4}}, 30.0 * unit, {}, 0.5 * unit}};
  const auto one = assemble(sprung), other = assemble(given);
  EXPECT_LT(difference(stiffness_of(one), stiffness_of(other)), 1e-15);  // rounding
  EXPECT_LT(difference(Eigen::MatrixXd(one.damping), Eigen::MatrixXd(other.damping)), 1e-15);

  given.matrices[0].mass = 4.0 * unit;
  EXPECT_NEAR(mass_of(assemble(given))(1, 1) - mass_of(one)(1, 1), 4.0, 4e-15);  // rounding of 4
  // What is tied passes its share on: the row goes to the master.
  given.links = {{.name = "rigid", .master = 0, .slaves = {1}}};
  EXPECT_EQ(assemble(given).size(), 6);
}

TEST(Joints, GeneralisedCoordinatesWeighNothing) {
  auto model = two_bodies();
  Eigen::SparseMatrix<double> modal(1, 1);
  modal.insert(0, 0) = 1.0;
  const auto mode = add_node(model.mesh, {0.0, 0.0, 0.0});
  model.matrices = {{"mode", {{mode, 0}}, 1e6 * modal, modal, {}}};
  EXPECT_NEAR(mass_properties(assemble(model)).mass, 6.0, 1e-14);  // rounding of sums
  model.mesh.node_sets[scalar_points] = {mode};
  EXPECT_NEAR(mass_properties(assemble(model)).mass, 5.0, 1e-14);
}

TEST(Joints, MatricesThatDoNotFitAreNamed) {
  auto model = two_bodies();
  Eigen::SparseMatrix<double> skew(2, 2);
  skew.insert(0, 1) = 1.0;
  model.matrices = {{"skew", {{0, 0}, {1, 0}}, skew, {}, {}}, {"short", {{0, 0}}, skew, {}, {}}};
  model.joints = {{"j", {{{0, 9}, 1.0}}, 1.0, 0.0}, {"empty", {}, 1.0, 0.0}};
  std::string text;
  for (const auto& issue : validate(model)) text += issue.what + "\n";
  for (const char* part :
       {"'skew' is not symmetric", "'short' is 2 x 2 for 1", "acts in direction 9", "'empty' has no"})
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
}

/// Four nodes around a fifth, which follows them.
FiniteElementModel followed(const std::vector<double>& weights) {
  Mesh mesh;
  for (const Eigen::Vector3d& place : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(2, 0, 0), Eigen::Vector3d(2, 1, 0),
                                       Eigen::Vector3d(0, 1, 0.5), Eigen::Vector3d(0.7, 0.2, 1.0)})
    add_node(mesh, place);
  auto model = model_of(std::move(mesh));
  WeightedLink link{.name = "mean", .follower = 4, .tied = {true, true, true, true, true, true}, .shares = {}};
  for (Eigen::Index node = 0; node < 4; ++node) {
    link.shares.push_back({node, weights[static_cast<std::size_t>(node)], {true, true, true, false, false, false}});
    model.masses.push_back(
        {.name = "m" + std::to_string(node), .node = node, .mass = 1.0, .inertia = 0.1 * Eigen::Matrix3d::Identity()});
  }
  model.weighted_links = {link};
  return model;
}

TEST(WeightedLink, FollowsRigidBodyMotionsExactly) {
  const auto model = followed({1.0, 2.0, 0.5, 3.0});
  const auto elimination = eliminate(model, std::vector<bool>(30, true));
  ASSERT_EQ(elimination.dofs.size(), 24U);
  const Eigen::Vector3d shift(0.1, -0.2, 0.3), turn(0.02, 0.5, -0.1);
  Eigen::VectorXd all(30);
  for (Eigen::Index node = 0; node < 5; ++node)
    all.segment<6>(6 * node) << shift + turn.cross(Eigen::Vector3d(model.mesh.nodes.col(node))), turn;
  EXPECT_LT((elimination.transform * all.head(24) - all).norm(), 4e-15);  // rounding
}

TEST(WeightedLink, SharesAForceByItsWeights) {
  // A force through the weighted centre goes to the nodes by their weights; T^T f is the load on the free ones.
  auto model = followed({1.0, 1.0, 2.0, 4.0});
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (Eigen::Index node = 0; node < 4; ++node)
    centre += model.weighted_links[0].shares[static_cast<std::size_t>(node)].weight / 8.0 * model.mesh.nodes.col(node);
  model.mesh.nodes.col(4) = centre;
  const auto elimination = eliminate(model, std::vector<bool>(30, true));
  Eigen::VectorXd force = Eigen::VectorXd::Zero(30);
  force[24 + 2] = 16.0;
  const Eigen::VectorXd load = elimination.transform.transpose() * force;
  // rounding of forces up to 8
  for (const auto& [node, share] : {std::pair{0, 2.0}, {1, 2.0}, {2, 4.0}, {3, 8.0}}) {
    EXPECT_NEAR(load[6 * node + 2], share, 5e-15);
    EXPECT_NEAR(load.segment<2>(6 * node).norm(), 0.0, 5e-15);
  }
}

TEST(WeightedLink, NodesOnALineLeaveTheTurnAboutItOpen) {
  auto model = followed({1.0, 1.0, 1.0, 1.0});
  for (Eigen::Index node = 0; node < 5; ++node) model.mesh.nodes.col(node) = Eigen::Vector3d(0.3 * double(node), 0, 0);
  std::string text;
  for (const auto& issue : constraint_issues(model)) text += issue.what + "\n";
  EXPECT_NE(text.find("leaves n5.rx open"), std::string::npos) << text;
  model.weighted_links[0].tied[3] = false;
  EXPECT_TRUE(constraint_issues(model).empty());
}

}  // namespace
}  // namespace kalfem
