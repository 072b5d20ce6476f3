// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/assembly/constraints.hpp"
#include "kalfem/model/assembly/assembly.hpp"

#include <gtest/gtest.h>

#include "kalfem/model/assembly/rigid_body.hpp"
#include "kalfem/model/mesh/connectivity.hpp"
#include "model/fe_models.hpp"

namespace kalfem {
namespace {

using namespace test;

FixedNodes fix(const std::string& name, std::vector<Eigen::Index> nodes,
               std::array<bool, 6> directions = {true, true, true, true, true, true}) {
  return {.name = name, .nodes = std::move(nodes), .directions = directions};
}

RigidLink link(const std::string& name, Eigen::Index master, std::vector<Eigen::Index> slaves) {
  return {.name = name, .master = master, .slaves = std::move(slaves)};
}

NodalSpring spring_to_ground(const std::string& name, const NodalDof& from, double stiffness) {
  NodalSpring spring;
  spring.name = name;
  spring.from = from;
  spring.stiffness = stiffness;
  return spring;
}

PointMass body(const std::string& name, Eigen::Index node, double mass, double inertia) {
  PointMass point;
  point.name = name;
  point.node = node;
  point.mass = mass;
  point.inertia = inertia * Eigen::Matrix3d::Identity();
  return point;
}

/// Displacements of all nodes in a rigid-body motion.
Eigen::VectorXd rigid_motion(const Mesh& mesh, const Eigen::Vector3d& shift, const Eigen::Vector3d& turn) {
  Eigen::VectorXd motion(6 * mesh.node_count());
  for (Eigen::Index node = 0; node < mesh.node_count(); ++node) {
    motion.segment<3>(6 * node) = shift + turn.cross(Eigen::Vector3d(mesh.nodes.col(node)));
    motion.segment<3>(6 * node + 3) = turn;
  }
  return motion;
}

/// Free part of a motion of all nodes.
Eigen::VectorXd free_part(const AssembledModel& assembled, const Eigen::VectorXd& all) {
  Eigen::VectorXd free(assembled.size());
  for (Eigen::Index i = 0; i < free.size(); ++i) free[i] = all[all_index(assembled.dofs[static_cast<std::size_t>(i)])];
  return free;
}

/// Of the norm of what is compared; most are found exact.
constexpr double rounding = 1e-15;

TEST(RigidLinks, LeverCarriesSpringAndMassByItsArms) {
  // A body turns about z at the origin; a spring in y stands at x = a, a mass at x = -b: k a^2 and J + m b^2.
  const double a = 0.7, b = 0.4, k = 3e4, m = 2.5, inertia = 0.3;
  Mesh mesh;
  for (const double x : {0.0, a, -b}) add_node(mesh, {x, 0.0, 0.0});
  auto model = model_of(mesh);
  model.springs = {spring_to_ground("s", {1, 1}, k)};
  model.masses = {body("hub", 0, 1.0, inertia), body("weight", 2, m, 0.0)};
  model.links = {link("lever", 0, {1, 2})};
  model.fixed = {fix("pin", {0}, {true, true, true, true, true, false})};
  const auto assembled = assemble(model);
  ASSERT_EQ(assembled.size(), 1);
  EXPECT_EQ(assembled.dofs[0], (NodalDof{0, 5}));
  EXPECT_NEAR(stiffness_of(assembled)(0, 0), k * a * a, rounding * k);
  EXPECT_NEAR(mass_of(assembled)(0, 0), inertia + m * b * b, rounding);
  ASSERT_EQ(assembled.grounds.size(), 1u);
  EXPECT_NEAR(assembled.grounds[0].stiffness[0], k * a, rounding * k);  // the ground's rise turns the lever
  EXPECT_NEAR(assembled.expansion.coeff(6 * 1 + 1, 0), a, rounding);
  EXPECT_NEAR(assembled.expansion.coeff(6 * 2 + 1, 0), -b, rounding);
  EXPECT_EQ(assembled.expansion.coeff(6 * 2 + 5, 0), 1.0);
  EXPECT_EQ(assembled.find({1, 1}), -1);
}

TEST(RigidLinks, ExpansionOfARigidMotionIsTheRigidMotionOfEveryNode) {
  auto model = beam_model({1.0, 0.5, 0.2}, 3, rectangular_section(0.04, 0.06));
  const auto arm = add_node(model.mesh, {1.2, 0.9, -0.5}), tip = add_node(model.mesh, {-0.3, 2.0, 0.7});
  model.links = {link("tip", arm, {tip}), link("arm", 3, {arm})};  // the order of the list does not matter
  const auto assembled = assemble(model);
  const auto all = rigid_motion(model.mesh, {0.3, -0.2, 0.9}, {0.5, 0.4, -1.1});
  const auto free = free_part(assembled, all);
  EXPECT_LT((assembled.expansion * free - all).norm(), rounding * all.norm());
  EXPECT_LT(
      (rigid_body_modes(model, assembled) * Eigen::Vector<double, 6>(0.3, -0.2, 0.9, 0.5, 0.4, -1.1) - free).norm(),
      rounding * free.norm());
}

TEST(RigidLinks, ConstrainedModelsKeepTheirSixRigidMotions) {
  // Two bars, the second hung on the first by a chain of links, an offset mass and a constraint that copies a
  // displacement of a third node.
  Mesh mesh = line_mesh({0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, 2, "first");
  const auto a = add_node(mesh, {1.0, 0.3, 0.0}), b = add_node(mesh, {1.0, 0.3, 0.4}),
             c = add_node(mesh, {1.5, 0.9, 0.4});
  add_cell(mesh, "second", CellShape::line2, {b, c});
  auto model = model_of(mesh);
  model.properties["first"] = beam_property(rectangular_section(0.04, 0.06));
  model.properties["second"] = beam_property(circular_tube_section(0.05, 0.004), {0.0, 0.01, 0.02});
  model.links = {link("one", 2, {a}), link("two", a, {b})};
  model.masses = {body("m", c, 1.3, 0.02)};
  model.masses[0].offset = {0.1, 0.2, 0.3};
  const auto assembled = assemble(model);
  const auto rigid = rigid_body_modes(model, assembled);
  const auto stiffness = stiffness_of(assembled);
  // Rounding of the products, of which few are as large as the norms.
  EXPECT_LT((stiffness * rigid).norm(), 1e-16 * stiffness.norm() * rigid.norm());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(stiffness);
  EXPECT_GT(solver.eigenvalues()[6], 1e-8 * solver.eigenvalues().maxCoeff());
  EXPECT_TRUE(find_mechanisms(model, assembled).empty());
}

TEST(RigidLinks, ChainOfLinksIsOneLink) {
  const auto chained = [] {
    auto model = beam_model({1.0, 0.0, 0.0}, 1, rectangular_section(0.04, 0.06));
    add_node(model.mesh, {1.1, 0.2, 0.0});
    add_node(model.mesh, {1.3, 0.2, 0.5});
    model.masses = {body("m", 3, 2.0, 0.1)};
    return model;
  };
  auto chain = chained(), star = chained();
  chain.links = {link("outer", 2, {3}), link("inner", 1, {2})};
  star.links = {link("both", 1, {2, 3})};
  const auto one = assemble(chain), other = assemble(star);
  EXPECT_EQ(one.dofs, other.dofs);
  EXPECT_LT(difference(mass_of(one), mass_of(other)), rounding);
  EXPECT_LT(difference(Eigen::MatrixXd(one.expansion), Eigen::MatrixXd(other.expansion)), rounding);
}

TEST(RigidLinks, OnlyTiedDirectionsFollow) {
  auto model = beam_model({1.0, 0.0, 0.0}, 2, rectangular_section(0.04, 0.06));
  model.links = {{.name = "slider", .master = 0, .slaves = {2}, .tied = {false, false, true, false, false, false}}};
  const auto assembled = assemble(model);
  EXPECT_EQ(assembled.size(), 17);
  EXPECT_EQ(assembled.find({2, 2}), -1);
  // z_2 = z_0 + (theta x r)_z with r = (1, 0, 0): - theta_y.
  EXPECT_EQ(assembled.expansion.coeff(6 * 2 + 2, assembled.find({0, 2})), 1.0);
  EXPECT_EQ(assembled.expansion.coeff(6 * 2 + 2, assembled.find({0, 4})), -1.0);
}

TEST(RigidLinks, LinkAndItsEquationsAreTheSameModel) {
  auto linked = beam_model({1.0, 0.0, 0.0}, 2, rectangular_section(0.04, 0.06));
  const auto extra = add_node(linked.mesh, {1.0, 0.25, -0.1});
  linked.masses = {body("m", extra, 2.0, 0.1)};
  auto written = linked;
  linked.links = {link("l", 2, {extra})};
  const double y = 0.25, z = -0.1;
  // Any common factor, and terms after the first in any order.
  written.constraints = {{"x", {{{extra, 0}, 2.0}, {{2, 4}, -2.0 * z}, {{2, 0}, -2.0}, {{2, 5}, 2.0 * y}}},
                         {"y", {{{extra, 1}, 1.0}, {{2, 1}, -1.0}, {{2, 3}, z}}},
                         {"z", {{{extra, 2}, -1.0}, {{2, 2}, 1.0}, {{2, 3}, y}}},
                         {"rx", {{{extra, 3}, 1.0}, {{2, 3}, -1.0}}},
                         {"ry", {{{extra, 4}, 1.0}, {{2, 4}, -1.0}}},
                         {"rz", {{{extra, 5}, 1.0}, {{2, 5}, -1.0}}}};
  const auto one = assemble(linked), other = assemble(written);
  EXPECT_EQ(one.dofs, other.dofs);
  EXPECT_LT(difference(mass_of(one), mass_of(other)), rounding);
  EXPECT_LT(difference(Eigen::MatrixXd(one.expansion), Eigen::MatrixXd(other.expansion)), rounding);
}

TEST(MultiPointConstraints, MatchTheEliminationByTheNullSpaceOfTheConstraints) {
  // Frequencies of the constrained bar against those in an orthonormal basis of all motions that fulfil C z = 0.
  auto model = beam_model({1.0, 0.0, 0.0}, 3, rectangular_section(0.04, 0.06));
  const auto free = assemble(model);
  model.constraints = {{"a", {{{3, 1}, 2.0}, {{1, 1}, 1.0}, {{2, 5}, -0.3}}},
                       {"b", {{{1, 1}, 1.0}, {{0, 1}, -0.5}, {{2, 2}, 0.25}}}};  // a's term follows from b
  model.fixed = {fix("wall", {0}, {true, true, true, true, false, false})};
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(6, free.size());
  for (int i = 0; i < 4; ++i) rows(i, i) = 1.0;
  rows(4, free.find({3, 1})) = 2.0;
  rows(4, free.find({1, 1})) = 1.0;
  rows(4, free.find({2, 5})) = -0.3;
  rows(5, free.find({1, 1})) = 1.0;
  rows(5, free.find({0, 1})) = -0.5;
  rows(5, free.find({2, 2})) = 0.25;
  const Eigen::MatrixXd basis = Eigen::FullPivLU<Eigen::MatrixXd>(rows).kernel();
  const auto values = [](const Eigen::MatrixXd& k, const Eigen::MatrixXd& m) -> Eigen::VectorXd {
    return Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>(k, m, Eigen::EigenvaluesOnly).eigenvalues();
  };
  const auto assembled = assemble(model);
  const Eigen::VectorXd expected =
      values(basis.transpose() * stiffness_of(free) * basis, basis.transpose() * mass_of(free) * basis);
  const Eigen::VectorXd found = values(stiffness_of(assembled), mass_of(assembled));
  ASSERT_EQ(found.size(), expected.size());
  // Rounding of the largest eigenvalue spreads over all: found 8e-16 of it.
  EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 1e-14 * expected.maxCoeff());
  EXPECT_LT((rows * free_part(free, assembled.expansion * Eigen::VectorXd::LinSpaced(found.size(), 1.0, 2.0))).norm(),
            3e-14);  // rounding of values up to the number of unknowns
}

TEST(Constraints, FixedMasterHoldsItsSlaves) {
  auto model = beam_model({1.0, 0.0, 0.0}, 1, rectangular_section(0.04, 0.06));
  const auto hub = add_node(model.mesh, {-0.2, 0.1, 0.0});
  auto clamped = model;
  model.links = {link("hub", hub, {0})};
  model.fixed = {fix("wall", {hub})};
  clamped.fixed = {fix("wall", {0})};
  EXPECT_LT(difference(stiffness_of(assemble(model)), stiffness_of(assemble(clamped))), rounding);
  EXPECT_EQ(Eigen::MatrixXd(assemble(model).expansion).topRows(6).norm(), 0.0);
}

TEST(Constraints, DegreesOfFreedomThatNothingTouchesAreNotNumbered) {
  auto model = beam_model({1.0, 0.0, 0.0}, 1, rectangular_section(0.04, 0.06));
  add_node(model.mesh, {5.0, 0.0, 0.0});
  const auto hung = add_node(model.mesh, {0.0, 1.0, 0.0});
  NodalSpring spring = spring_to_ground("s", {0, 2}, 1e3);
  spring.to = NodalDof{hung, 2};
  model.springs = {spring};
  model.masses = {body("m", hung, 1.0, 0.0)};
  const auto assembled = assemble(model);
  EXPECT_EQ(assembled.size(), 12 + 3);
  EXPECT_EQ(assembled.find({2, 0}), -1);
  EXPECT_EQ(assembled.find({hung, 3}), -1);
  EXPECT_EQ(assembled.find({hung, 2}), 14);
}

TEST(Constraints, ContradictionsAreNamed) {
  auto model = beam_model({1.0, 0.0, 0.0}, 3, rectangular_section(0.04, 0.06));
  model.links = {link("a", 0, {1, 2}), link("b", 3, {2}), link("self", 3, {3})};
  model.fixed = {fix("wall", {1})};
  model.constraints = {{"none", {}},
                       {"zero", {{{0, 0}, 1.0}, {{1, 0}, 1.0}, {{0, 0}, -1.0}}},
                       {"nan", {{{0, 0}, std::nan("")}}},
                       {"again", {{{2, 0}, 1.0}, {{0, 1}, 1.0}}}};
  const auto issues = issues_of(model);
  for (const char* part :
       {"n3.x and 5 others follow from 'a' and from 'b'", "n3.x follows from 'a' and from 'again'",
        "n2.x and 5 others are fixed and follow from 'a'", "rigid link 'self' ties its master n4 to itself",
        "constraint 'none' has no terms", "'zero' has the coefficient 0 at its first term n1.x",
        "'nan' has a coefficient that is not finite"})
    EXPECT_NE(issues.find(part), std::string::npos) << part << "\n" << issues;
  EXPECT_EQ(issues.find("n3.y follows"), std::string::npos) << "once a node";
}

TEST(Constraints, RingsAreNamed) {
  auto model = beam_model({1.0, 0.0, 0.0}, 3, rectangular_section(0.04, 0.06));
  model.links = {link("there", 0, {1}), link("on", 1, {2}), link("back", 2, {0})};
  const auto issues = issues_of(model);
  EXPECT_NE(issues.find("'back', 'on', 'there': their degrees of freedom depend on one another in a circle"),
            std::string::npos)
      << issues;
  EXPECT_THROW(assemble(model), InvalidInput);
}

TEST(Connectivity, PartsAreFoundAndNamed) {
  Mesh mesh = line_mesh({0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, 3, "left");
  const auto a = add_node(mesh, {2.0, 0.0, 0.0}), b = add_node(mesh, {3.0, 0.0, 0.0});
  add_cell(mesh, "right", CellShape::line2, {a, b});
  add_node(mesh, {9.0, 9.0, 9.0});  // belongs to nothing
  auto model = model_of(mesh);
  model.properties["left"] = model.properties["right"] = beam_property(rectangular_section(0.04, 0.06));
  const auto parts = connected_parts(model);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0], (std::vector<Eigen::Index>{0, 1, 2, 3}));
  EXPECT_EQ(parts[1], (std::vector<Eigen::Index>{4, 5}));
  EXPECT_NE(
      message_of([&] {
        require_connected(model);
      }).find("consists of 2 unconnected parts: 4 nodes with n1 in region 'left', 2 nodes with n5 in region 'right'"),
      std::string::npos);
  auto tied = model, sprung = model, bound = model;
  tied.links = {link("l", 3, {4})};
  sprung.springs = {spring_to_ground("s", {3, 0}, 1.0)};
  EXPECT_EQ(connected_parts(sprung).size(), 2u);
  sprung.springs[0].to = NodalDof{4, 0};
  bound.constraints = {{"c", {{{3, 0}, 1.0}, {{4, 0}, -1.0}}}};
  for (const auto& joined : {tied, sprung, bound}) EXPECT_NO_THROW(require_connected(joined));
  // Parts that each are held, or that something outside joins, are legitimate.
  auto held = model;
  held.fixed = {fix("wall", {0})};
  EXPECT_THROW(require_connected(held), InvalidInput);
  EXPECT_TRUE(require_connected(held, {5}));
  held.fixed = {fix("walls", {0, 5})};
  EXPECT_FALSE(require_connected(held));
}

TEST(Mechanisms, SoundModelsHaveNone) {
  auto model = beam_model({1.0, 0.3, 0.0}, 200, rectangular_section(0.04, 0.06));
  EXPECT_TRUE(find_mechanisms(model, assemble(model)).empty()) << "free";
  model.fixed = {fix("wall", {0})};
  EXPECT_TRUE(find_mechanisms(model, assemble(model)).empty()) << "clamped";
  model.fixed = {fix("pin", {0}, {true, true, true, false, false, false})};
  EXPECT_TRUE(find_mechanisms(model, assemble(model)).empty()) << "turning about a pin is a rigid-body motion";
}

TEST(Mechanisms, HingeAndLooseRotationAreNamed) {
  // Two bars in line that share only displacements: the second turns about the joint in three ways beside the first.
  Mesh mesh = line_mesh({0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, 4, "first");
  const auto a = add_node(mesh, {1.0, 0.0, 0.0}), b = add_node(mesh, {2.0, 0.0, 0.0});
  add_cell(mesh, "second", CellShape::line2, {a, b});
  auto model = model_of(mesh);
  model.properties["first"] = model.properties["second"] = beam_property(rectangular_section(0.04, 0.06));
  RigidLink joint = link("joint", 4, {a});
  joint.tied = {true, true, true, false, false, false};
  model.links = {joint};
  model.fixed = {fix("wall", {0})};
  EXPECT_EQ(find_mechanisms(model, assemble(model)).size(), 3u);
  auto hinge = model;
  hinge.links[0].tied = {true, true, true, true, false, true};
  const auto found = find_mechanisms(hinge, assemble(hinge));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(found[0] == "n6.ry" || found[0] == "n7.ry" || found[0] == "n7.z") << found[0];
  auto free_hinge = hinge;
  free_hinge.fixed.clear();
  EXPECT_EQ(find_mechanisms(free_hinge, assemble(free_hinge)).size(), 1u);
}

TEST(Mechanisms, DegreesOfFreedomWithoutStiffnessAreNamed) {
  auto model = beam_model({1.0, 0.0, 0.0}, 2, rectangular_section(0.04, 0.06));
  const auto hung = add_node(model.mesh, {1.0, 1.0, 0.0});
  NodalSpring spring = spring_to_ground("s", {2, 1}, 1e3);
  spring.to = NodalDof{hung, 1};
  model.springs = {spring};
  model.masses = {body("m", hung, 1.0, 0.1)};
  model.fixed = {fix("wall", {0})};
  EXPECT_EQ(find_mechanisms(model, assemble(model)),
            (std::vector<std::string>{"n4.x", "n4.z", "n4.rx", "n4.ry", "n4.rz"}));
}

// A mechanism leaves no factor, so a model with one needs no further look.
TEST(Mechanisms, OnlySoundModelsHaveAFactorThatIsHeldByTheirRigidBodyMotions) {
  auto model = beam_model({1.0, 0.3, 0.0}, 20, rectangular_section(0.04, 0.06));
  const auto rigid_modes = [&] {
    const auto assembled = assemble(model, {.at_present_values = true});
    const auto factor =
        factor_held(model, assembled, assembled.stiffness.front().matrix, assembled.mass.front().matrix);
    return factor ? factor->rigid_modes.cols() : -1;
  };
  EXPECT_EQ(rigid_modes(), 6) << "free";
  model.fixed = {fix("pin", {0}, {true, true, true, false, false, false})};
  EXPECT_EQ(rigid_modes(), 3) << "turning about a pin";
  model.fixed = {fix("wall", {0})};
  EXPECT_EQ(rigid_modes(), 0) << "clamped";
  model.fixed.clear();
  const auto hung = add_node(model.mesh, {1.0, 1.0, 0.0});
  NodalSpring spring = spring_to_ground("s", {2, 1}, 1e3);
  spring.to = NodalDof{hung, 1};
  model.springs = {spring};
  model.masses = {body("m", hung, 1.0, 0.1)};
  EXPECT_EQ(rigid_modes(), -1) << "a mass hangs on one spring";
}

}  // namespace
}  // namespace kalfem
