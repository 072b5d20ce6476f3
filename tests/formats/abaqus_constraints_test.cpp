// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/QR>
#include <random>
#include <set>

#include "formats/abaqus_decks.hpp"
#include "kalfem/model/assembly/constraint_elimination.hpp"
#include "kalfem/model/assembly/constraints.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

/// Ten nodes along x without elements, for constraints alone.
FiniteElementModel bare_model() {
  FiniteElementModel model;
  model.mesh.nodes = Eigen::Matrix3Xd::Zero(3, 10);
  for (Index i = 0; i < 10; ++i) {
    model.mesh.node_ids.push_back(i + 1);
    model.mesh.nodes(0, i) = static_cast<double>(i);
  }
  return model;
}

/// Holds displacements along and rotations about the columns of `axes`, as supports in turned axes do.
void hold_in_axes(FiniteElementModel& model, Index node, const Eigen::Matrix3d& axes, const std::array<bool, 6>& held) {
  ReducedEquations equations;
  for (int d = 0; d < 6; ++d) {
    if (!held[static_cast<std::size_t>(d)]) continue;
    DofSum terms;
    for (int a = 0; a < 3; ++a) terms.push_back({NodalDof{node, d / 3 * 3 + a}, axes(a, d % 3)});
    equations.add("support", terms);
  }
  equations.store(model);
}

TEST(ReducedEquations, HeldDirectionsOfTurnedAxesDoNotMove) {
  const Eigen::Matrix3d axes =
      (Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()) * Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  for (int pattern = 1; pattern < 64; ++pattern) {
    auto model = bare_model();
    std::array<bool, 6> held{};
    int count = 0;
    for (std::size_t d = 0; d < 6; ++d) count += held[d] = (pattern >> d) & 1;
    hold_in_axes(model, 4, axes, held);
    const auto free = eliminate(model, std::vector<bool>(60, true));  // throws where they contradict each other
    EXPECT_EQ(static_cast<int>(free.dofs.size()), 60 - count);
    const Eigen::MatrixXd motion = Eigen::MatrixXd(free.transform).middleRows(24, 6);
    for (Index d = 0; d < 6; ++d)
      if (held[static_cast<std::size_t>(d)]) {
        EXPECT_LT((axes.col(d % 3).transpose() * motion.middleRows(d < 3 ? 0 : 3, 3)).norm(), 3e-15);  // rounding
      }
  }
}

TEST(ReducedEquations, AxesAlongTheGlobalOnesNeedNoConstraint) {
  auto model = bare_model();
  Eigen::Matrix3d axes;
  axes << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  hold_in_axes(model, 0, axes, {true, false, false, false, false, false});
  EXPECT_TRUE(model.constraints.empty());
  ASSERT_EQ(model.fixed.size(), 1u);
  EXPECT_TRUE(model.fixed.front().directions[1]);
}

TEST(ReducedEquations, EquationsThatFollowFromOthersAreLeftOut) {
  ReducedEquations equations;
  const NodalDof a{0, 0}, b{1, 0}, c{2, 0};
  EXPECT_TRUE(equations.add("1", {{a, 1.0}, {b, -1.0}}));
  EXPECT_TRUE(equations.add("2", {{b, 1.0}, {c, -1.0}}));
  EXPECT_FALSE(equations.add("3", {{a, 2.0}, {c, -2.0}}));
  auto model = bare_model();
  equations.store(model);
  EXPECT_EQ(model.constraints.size(), 2u);
  EXPECT_TRUE(constraint_issues(model).empty());
}

/// Forty equations of sixty degrees of freedom, each of which stands in several, a third of them sums of others: what
/// the constraints leave free is the null space of them all.
TEST(ReducedEquations, LeaveFreeWhatAllEquationsLeaveFree) {
  std::mt19937 random(11);
  const auto any = [&](Index below) { return static_cast<Index>(random() % static_cast<unsigned>(below)); };
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(40, 60);
  for (Index row = 0; row < 40; ++row) {
    if (row % 3 == 2)
      matrix.row(row) = 2.0 * matrix.row(any(row)) - matrix.row(any(row));
    else
      for (int term = 0; term < 6; ++term) matrix(row, any(20)) = static_cast<double>(1 + any(9)) - 4.5;
  }
  ReducedEquations equations;
  Index added = 0;
  for (Index row = 0; row < 40; ++row) {
    DofSum terms;
    for (Index i = 0; i < 60; ++i)
      if (matrix(row, i) != 0.0) terms.push_back({{i / 6, static_cast<int>(i % 6)}, matrix(row, i)});
    if (equations.add("any", terms)) ++added;
  }
  const Index rank = Eigen::ColPivHouseholderQR<Eigen::MatrixXd>(matrix).rank();
  EXPECT_EQ(added, rank);
  auto model = bare_model();
  equations.store(model);
  const auto free = eliminate(model, std::vector<bool>(60, true));
  EXPECT_EQ(static_cast<Index>(free.dofs.size()), 60 - rank);
  const Eigen::MatrixXd motions(free.transform);
  // rounding: the sums are of a few whole numbers
  EXPECT_LT((matrix * motions).norm(), 1e-14 * matrix.norm() * motions.norm());
}

/// A block of n x n x m C3D8I between two heights, numbers from `start` on; sets: NAMEbottom, NAMEtop.
std::string block(const std::string& name, int start, int n, int m, double from, double to) {
  std::string text = "*NODE\n", bottom = "*NSET, NSET=" + name + "bottom\n", top = "*NSET, NSET=" + name + "top\n";
  const auto id = [&](int i, int j, int k) { return start + i + (n + 1) * (j + (n + 1) * k); };
  for (int k = 0; k <= m; ++k)
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        text += std::to_string(id(i, j, k)) + "," + std::to_string(double(i) / n) + "," +
                std::to_string(double(j) / n) + "," + std::to_string(from + (to - from) * k / m) + "\n";
        if (k == 0) bottom += std::to_string(id(i, j, k)) + ",\n";
        if (k == m) top += std::to_string(id(i, j, k)) + ",\n";
      }
  std::string upper = "*ELSET, ELSET=" + name + "upper\n", lower = "*ELSET, ELSET=" + name + "lower\n";
  text += "*ELEMENT, TYPE=C3D8I, ELSET=" + name + "\n";
  int element = start;
  for (int k = 0; k < m; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        if (k == 0) lower += std::to_string(element) + ",\n";
        if (k == m - 1) upper += std::to_string(element) + ",\n";
        text += std::to_string(element++);
        for (int level = 0; level < 2; ++level)
          for (const auto& [a, b] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}})
            text += "," + std::to_string(id(i + a, j + b, k + level));
        text += "\n";
      }
  return text + bottom + top + lower + upper + "*SURFACE, NAME=" + name + "top\n" + name +
         "upper, S2\n*SURFACE, NAME=" + name + "bottom\n" + name + "lower, S1\n*SOLID SECTION, ELSET=" + name +
         ", MATERIAL=steel\n";
}

// Meshes that do not match, a gap between them: six motions without force, and elastic ones near those of one piece.
TEST(AbaqusTie, UnlikeMeshesMoveAsOneBody) {
  const std::string tie = "*TIE, NAME=t, POSITION TOLERANCE=0.02\nbbottom, atop\n";
  const auto tied =
      Matrices(parse_deck(deck_steel + block("a", 1, 3, 3, 0, 1) + block("b", 1000, 4, 3, 1.01, 2) + tie).model)
          .frequencies(9);
  const auto whole = Matrices(parse_deck(deck_steel + block("a", 1, 3, 6, 0, 2)).model).frequencies(9);
  // motions without strain are exact; meshes that do not match and a gap of 1 % change the others by .4 %
  for (Index i = 0; i < 6; ++i) EXPECT_LT(tied[i], 1e-9 * whole[6]);
  for (Index i = 6; i < 9; ++i) EXPECT_NEAR(tied[i], whole[i], 0.01 * whole[i]);
}

// Tied nodes off their faces take the turning of the faces along: a rigid rotation of the free nodes is one of all.
TEST(AbaqusTie, NodesAboveTheirFacesTurnWithThem) {
  const auto model = parse_deck(deck_steel + block("a", 1, 3, 3, 0, 1) + block("b", 1000, 4, 3, 1.1, 2) +
                                "*TIE, NAME=t, POSITION TOLERANCE=0.2\nbbottom, atop\n")
                         .model;
  const auto assembled = assemble(model);
  const Eigen::Vector3d turn(0.3, -0.5, 0.7);
  const auto motion = [&](const NodalDof& dof) { return turn.cross(model.mesh.nodes.col(dof.node))[dof.direction]; };
  Eigen::VectorXd free(assembled.size());
  for (Index i = 0; i < assembled.size(); ++i) free[i] = motion(assembled.dofs[static_cast<std::size_t>(i)]);
  const Eigen::VectorXd all = assembled.expansion * free;
  for (Index node = 0; node < model.mesh.node_count(); ++node)
    for (int d = 0; d < 3; ++d) EXPECT_NEAR(all[6 * node + d], motion({node, d}), 3e-15);  // rounding
}

TEST(AbaqusTie, SurfacesBeyondTheToleranceAreTold) {
  EXPECT_THROW(parse_deck(deck_steel + block("a", 1, 2, 1, 0, 1) + block("b", 1000, 2, 1, 1.5, 2) +
                          "*TIE, NAME=t\nbbottom, atop\n"),
               InvalidInput);
}

/// Rounding of frequencies whose equations are eliminated in another order, relative.
constexpr double of_equations = 1e-12;

/// Frequencies of a block on its clamped bottom with something at its top.
Eigen::VectorXd of_block(const std::string& more, Index count = 4) {
  return Matrices(parse_deck(deck_steel + block("a", 1, 2, 3, 0, 2) +
                             "*BOUNDARY\nabottom, 1, 3\n*NODE\n500, 0.5, 0.5, 2.5\n" +
                             "*ELEMENT, TYPE=MASS, ELSET=m\n500, 500\n*MASS, ELSET=m\n4000.\n" + more)
                      .model)
      .frequencies(count);
}

const std::string inertia = "*ELEMENT, TYPE=ROTARYI, ELSET=r\n501, 500\n*ROTARY INERTIA, ELSET=r\n100., 100., 100.\n";

TEST(AbaqusCoupling, ManyWaysToWriteOneRigidBody) {
  const auto rigid = of_block(inertia + "*RIGID BODY, REF NODE=500, TIE NSET=atop\n");
  for (const std::string& other :
       {std::string("*COUPLING, CONSTRAINT NAME=c, REF NODE=500, SURFACE=atop\n*KINEMATIC\n"),
        std::string("*COUPLING, CONSTRAINT NAME=c, REF NODE=500, SURFACE=atop\n*KINEMATIC\n1, 3\n"),
        std::string("*KINEMATIC COUPLING, REF NODE=500\natop, 1, 6\n"), std::string("*MPC\nBEAM, atop, 500\n"),
        std::string("*ORIENTATION, NAME=o\n1,2,0,-2,1,0\n*COUPLING, CONSTRAINT NAME=c, REF NODE=500, SURFACE=atop, "
                    "ORIENTATION=o\n"
                    "*KINEMATIC\n1\n2\n3\n")})
    EXPECT_LT((of_block(inertia + other) - rigid).norm(), of_equations * rigid.norm()) << other;
}

/// CalculiX lets loads act on such a node, and nothing hold it.
TEST(AbaqusCoupling, AHeldMeanIsDoubtfulInCalculix) {
  const std::string held =
      "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n9, .3, .3, .3\n*ELEMENT, TYPE=C3D4, "
      "ELSET=E\n1, 1, 2, 3, 4\n" +
      deck_steel +
      "*SOLID SECTION, ELSET=E, MATERIAL=steel\n*SURFACE, NAME=S, TYPE=NODE\n2\n3\n4\n"
      "*COUPLING, CONSTRAINT NAME=C, REF NODE=9, SURFACE=S\n*DISTRIBUTING\n*BOUNDARY\n9, 1, 1\n";
  const auto is_told = [](const Deck& deck) {
    return std::ranges::any_of(deck.notes, [](const auto& note) {
      return note.what == "*BOUNDARY on the reference node of *DISTRIBUTING" && note.kind == DeckNoteKind::doubtful;
    });
  };
  EXPECT_TRUE(is_told(parse_deck(held)));
  EXPECT_FALSE(is_told(parse_deck("*PREPRINT\n" + held)));
}

// The block carries the mass without being stiffened: lower than with a rigid top, above the block with the mass at
// half its own height would be. A deck of Abaqus, where this coupling carries moments. The surface by faces weighs its
// nodes by area: nearly the same.
TEST(AbaqusCoupling, DistributingCouplingDoesNotStiffen) {
  const auto rigid = of_block(inertia + "*RIGID BODY, REF NODE=500, TIE NSET=atop\n");
  const auto soft = of_block(inertia + "*COUPLING, CONSTRAINT NAME=c, REF NODE=500, SURFACE=atop\n*DISTRIBUTING\n");
  const auto old = of_block(
      inertia + "*PREPRINT\n*ELEMENT, TYPE=DCOUP3D, ELSET=d\n600, 500\n*DISTRIBUTING COUPLING, ELSET=d\natop, 1.\n");
  for (Index i = 0; i < 4; ++i) {
    EXPECT_LT(soft[i], (1.0 + of_equations) * rigid[i]);
    EXPECT_GT(soft[i], 0.99 * rigid[i]);  // bending falls by .2 and .5 %
    // weights by area and equal ones: found .7 %
    EXPECT_NEAR(old[i], soft[i], 0.02 * soft[i]);
  }
  EXPECT_NEAR(soft[2] / rigid[2], 1.0, of_equations);  // torsion is the same
  EXPECT_LT(soft[0], 0.999 * rigid[0]);
}

// A held reference node of a distributing coupling holds the mean motion of its nodes: the same as by hand.
TEST(AbaqusCoupling, HeldReferenceNodeHoldsTheMeanMotion) {
  std::string equation = "*EQUATION\n9\n";
  for (int node = 28; node <= 36; ++node) equation += std::to_string(node) + ", 3, 1.\n";
  const std::string free_nodes = "*BOUNDARY\n500, 1, 6\n";
  const std::string by_nodes =
      "*SURFACE, NAME=s, TYPE=NODE\natop, 1.\n*COUPLING, CONSTRAINT NAME=c, REF NODE=510, SURFACE=s\n*DISTRIBUTING\n"
      "*NODE\n510, 0.5, 0.5, 2.\n*BOUNDARY\n510, 3\n";
  const auto by_equation = of_block(free_nodes + equation);
  EXPECT_LT((of_block(free_nodes + by_nodes) - by_equation).norm(), of_equations * by_equation.norm());
}

// The reference node of a coupling and nodes that follow it may be the coordinates of a reduction's boundary.
TEST(AbaqusCoupling, ReferencesAndFollowersMayBeCoordinates) {
  for (const auto& [link, id] :
       {std::pair{std::string("*COUPLING, CONSTRAINT NAME=c, REF NODE=500, SURFACE=atop\n*DISTRIBUTING\n"), 500},
        std::pair{std::string("*COUPLING, CONSTRAINT NAME=c, REF NODE=500, SURFACE=atop\n*KINEMATIC\n"), 32},
        std::pair{std::string("*RIGID BODY, REF NODE=500, TIE NSET=atop\n"), 36}}) {
    const auto model =
        parse_deck(deck_steel + block("a", 1, 2, 3, 0, 2) + "*BOUNDARY\nabottom, 1, 3\n*NODE\n500, 0.5, 0.5, 2.5\n" +
                   "*ELEMENT, TYPE=MASS, ELSET=m\n500, 500\n*MASS, ELSET=m\n4000.\n" + inertia + link)
            .model;
    const Index node = NodeFinder(model.mesh).find(id);
    const std::vector<NodalDof> wanted = {{node, 0}, {node, 1}, {node, 2}};
    const auto turned = assemble(model, {.independent = wanted});
    for (const auto& dof : wanted) EXPECT_GE(turned.find(dof), 0) << link;
    const auto modes = lowest_modes(evaluate(turned.stiffness, turned.parameters),
                                    evaluate(turned.mass, turned.parameters), {.count = 4});
    const Eigen::VectorXd found = modes.values.cwiseSqrt() / (2.0 * std::numbers::pi);
    const Eigen::VectorXd expected = Matrices(model).frequencies(4);
    EXPECT_LT((found - expected).norm(), of_equations * expected.norm()) << link;
  }
}

// Supports of nodes that follow act on the one that leads them: here 0.5 above, u_x = 0.5 theta_y and theta_z = 0.
TEST(AbaqusCoupling, SupportsOfSlavesHoldTheirMaster) {
  const std::string body = inertia + "*RIGID BODY, REF NODE=500, TIE NSET=atop\n";
  const auto at_slaves = of_block(body + "*BOUNDARY\natop, 1\n");
  const auto at_master = of_block(body + "*BOUNDARY\n500, 6\n*EQUATION\n2\n500, 1, 1., 500, 5, -0.5\n");
  EXPECT_LT((at_slaves - at_master).norm(), of_equations * at_master.norm());
}

TEST(AbaqusBoundary, NamedSupportsAndTheFirstStep) {
  const std::string plate = "*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n*ELEMENT, TYPE=S4, ELSET=e\n1,1,2,3,4\n" +
                            deck_steel + "*SHELL SECTION, ELSET=e, MATERIAL=steel\n0.01\n";
  const auto size = [&](const std::string& more) { return assemble(parse_deck(plate + more).model).size(); };
  EXPECT_EQ(size("*BOUNDARY\n1, ENCASTRE\n2, PINNED\n3, XSYMM\n4, 3\n"), 24 - 6 - 3 - 3 - 1);
  EXPECT_EQ(size("*BOUNDARY\n1, 1, 3\n*STEP\n*FREQUENCY\n3\n*BOUNDARY\n2, 1\n*END STEP\n"), 20);
  EXPECT_EQ(size("*BOUNDARY\n1, 1, 3\n*STEP\n*FREQUENCY\n3\n*BOUNDARY, OP=NEW\n2, 1\n*END STEP\n"), 23);
  EXPECT_EQ(size("*BOUNDARY\n1, 1, 3\n*STEP\n*END STEP\n*STEP\n*BOUNDARY\n2, 1\n*END STEP\n"), 21);
  EXPECT_EQ(parse_deck(plate + "*BOUNDARY\n1, 1, 1, 0.5\n").notes.size(), 1u);
}

}  // namespace
}  // namespace kalfem
