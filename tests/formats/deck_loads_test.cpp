// SPDX-License-Identifier: Apache-2.0
// Static load cases of decks: forces, pressures, gravity and supports that move.
#include <gtest/gtest.h>

#include "formats/abaqus_decks.hpp"
#include "formats/nastran_decks.hpp"
#include "kalfem/model/statics/statics.hpp"

namespace kalfem {
namespace {

using Eigen::Vector3d;

Deck abaqus(const std::string& text) { return parse_abaqus(text, "deck.inp", {}, {.load_cases = true}); }
Deck nastran(const std::string& text) { return parse_nastran(text, "deck.bdf", {}, {.load_cases = true}); }

template <class Read>
std::string problem(Read read, const std::string& text) {
  try {
    read(text);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

const LoadCase& case_named(const Deck& deck, const std::string& name) {
  const auto found = std::ranges::find(deck.load_cases, name, &LoadCase::name);
  if (found == deck.load_cases.end()) throw std::logic_error("there is no load case " + name);
  return *found;
}

/// Sum of the nodal forces of a load case.
Vector3d total(const Deck& deck, const std::string& name) {
  const auto forces = nodal_forces(deck.model, case_named(deck, name));
  Vector3d sum = Vector3d::Zero();
  for (Eigen::Index node = 0; node < deck.model.mesh.node_count(); ++node) sum += forces.segment<3>(6 * node);
  return sum;
}

void expect_near(const Vector3d& found, const Vector3d& expected) {
  EXPECT_LE((found - expected).norm(), 1e-12 * (1.0 + expected.norm()))
      << found.transpose() << " instead of " << expected.transpose();
}

Vector3d displacement(const Deck& deck, const std::string& name, Eigen::Index node) {
  return solve_statics(deck.model, case_named(deck, name)).displacements.segment<3>(6 * node);
}

/// A unit cube of nodes 1 to 8, held at x = 0, and a plate of nodes 11 to 14 in the plane z = 2, all held but 13.
const std::string abaqus_bodies = R"(*NODE, NSET=ALL
1, 0, 0, 0
2, 1, 0, 0
3, 1, 1, 0
4, 0, 1, 0
5, 0, 0, 1
6, 1, 0, 1
7, 1, 1, 1
8, 0, 1, 1
11, 0, 0, 2
12, 1, 0, 2
13, 1, 1, 2
14, 0, 1, 2
*NSET, NSET=WALL
1, 4, 5, 8
*ELEMENT, TYPE=C3D8, ELSET=CUBE
1, 1, 2, 3, 4, 5, 6, 7, 8
*ELEMENT, TYPE=S4, ELSET=PLATE
2, 11, 12, 13, 14
*ELSET, ELSET=EVERYTHING
CUBE, PLATE
*SURFACE, NAME=TOP
CUBE, S2
*SURFACE, NAME=UNDER
PLATE, SNEG
*SOLID SECTION, ELSET=CUBE, MATERIAL=M
*SHELL SECTION, ELSET=PLATE, MATERIAL=M
0.01
*MATERIAL, NAME=M
*ELASTIC
1000., 0.
*DENSITY
2.
*BOUNDARY
WALL, 1, 3
11, 1, 6
12, 1, 6
14, 1, 6
)";

std::string step(const std::string& loads, const std::string& options = "") {
  return "*STEP" + options + "\n*STATIC\n" + loads + "*END STEP\n";
}

TEST(AbaqusLoads, AreOneCaseAStep) {
  const auto deck = abaqus(abaqus_bodies + step("*CLOAD\n2, 1, 5.\n3, 2, 1.\n") + step("*CLOAD\n2, 1, 7.\n") +
                           step("*CLOAD, OP=NEW\n2, 3, 2.\n") + "*STEP\n*FREQUENCY\n4\n*END STEP\n");
  ASSERT_EQ(deck.load_cases.size(), 3u);
  expect_near(total(deck, "step1"), {5, 1, 0});
  expect_near(total(deck, "step2"), {7, 1, 0});  // the earlier force goes on, the other one changes
  expect_near(total(deck, "step3"), {0, 0, 2});
}

TEST(AbaqusLoads, OfAPerturbationStandAlone) {
  const auto deck = abaqus("*PREPRINT\n" + abaqus_bodies + step("*CLOAD\n2, 1, 5.\n") +
                           step("*CLOAD\n2, 2, 3.\n", ", PERTURBATION") + step("*CLOAD\n2, 3, 1.\n"));
  expect_near(total(deck, "step2"), {0, 3, 0});
  expect_near(total(deck, "step3"), {5, 0, 1});
}

TEST(AbaqusLoads, PressIntoSolidsAndAlongNormalsOfShells) {
  const auto load = [](const std::string& line) { return total(abaqus(abaqus_bodies + step(line)), "step1"); };
  expect_near(load("*DLOAD\nCUBE, P1, 3.\n"), {0, 0, 3});   // nodes 1 2 3 4 below
  expect_near(load("*DLOAD\nCUBE, P2, 3.\n"), {0, 0, -3});  // 5 8 7 6 above
  expect_near(load("*DLOAD\nCUBE, P4, 3.\n"), {-3, 0, 0});  // 2 3 7 6
  expect_near(load("*DSLOAD\nTOP, P, 3.\n"), {0, 0, -3});
  expect_near(load("*DLOAD\nPLATE, P, 3.\n"), {0, 0, 3});
  expect_near(load("*DSLOAD\nUNDER, P, 3.\n"), {0, 0, 3});
}

TEST(AbaqusLoads, WeighTheWholeModel) {
  const auto deck = abaqus(abaqus_bodies + step("*DLOAD\nEVERYTHING, GRAV, 9.81, 0., 0., -2.\n"));
  expect_near(case_named(deck, "step1").gravity, {0, 0, -9.81});
  const auto part = abaqus(abaqus_bodies + step("*DLOAD\nCUBE, GRAV, 9.81, 0., 0., -1.\n"));
  EXPECT_TRUE(case_named(part, "step1").gravity.isZero(0.0));
  expect_near(total(part, "step1"), {0, 0, -2 * 9.81});
}

/// The free end of the cube is pulled by 1 % along x by a support that moves: sigma = E 0.01 at nu = 0.
TEST(AbaqusLoads, MoveSupports) {
  const auto pulled =
      abaqus(abaqus_bodies + step("*BOUNDARY\n2, 1, 1, 0.01\n3, 1, 1, 0.01\n6, 1, 1, 0.01\n7, 1, 1, 0.01\n"));
  EXPECT_NEAR(displacement(pulled, "step1", 1).x(), 0.01, 1e-15);
  const auto reactions = solve_statics(pulled.model, case_named(pulled, "step1"));
  double wall = 0.0;
  for (const auto& reaction : reactions.reactions)
    if (reaction.name == "WALL") wall = reaction.sum.force.x();
  EXPECT_NEAR(wall, -1000.0 * 0.01, 1e-11);
  // The same by an equation: u(2) = 0.5 u(ref), and so on, with a reference node that is moved by 0.02.
  std::string tied = abaqus_bodies;
  tied.insert(tied.find("*NSET"), "20, 5, 5, 5\n");
  for (const char* node : {"2", "3", "6", "7"}) tied += std::string("*EQUATION\n2\n") + node + ", 1, 1., 20, 1, -0.5\n";
  const auto by_reference = abaqus(tied + step("*BOUNDARY\n20, 1, 1, 0.02\n20, 2, 3\n"));
  EXPECT_NEAR(displacement(by_reference, "step1", 1).x(), 0.01, 1e-15);
}

TEST(AbaqusLoads, TurnWithTheAxesOfTheirNode) {
  const std::string turned = "*NSET, NSET=T\n2\n*TRANSFORM, NSET=T\n0, 1, 0, -1, 0, 0\n";
  expect_near(total(abaqus(abaqus_bodies + turned + step("*CLOAD\n2, 1, 4.\n")), "step1"), {0, 4, 0});
}

/// Node 2 is moved along its own first axis, [0, 0.6, 0.8], and held along its second one, -x.
TEST(AbaqusLoads, MoveSupportsAlongTheAxesOfTheirNode) {
  const std::string turned = "*NSET, NSET=T\n2\n*TRANSFORM, NSET=T\n0, 3, 4, -1, 0, 0\n";
  const auto deck = abaqus(abaqus_bodies + turned + step("*BOUNDARY\n2, 1, 1, 0.01\n2, 2, 2\n"));
  const auto moved = displacement(deck, "step1", 1);
  EXPECT_NEAR(0.6 * moved.y() + 0.8 * moved.z(), 0.01, 1e-15);
  EXPECT_NEAR(moved.x(), 0.0, 1e-15);
  EXPECT_LT(solve_statics(deck.model, case_named(deck, "step1")).imbalance, 1e-9);
}

TEST(AbaqusLoads, AreRefusedWhereTheyMakeNoSense) {
  const auto refused = [](const std::string& loads) { return problem(abaqus, abaqus_bodies + step(loads)); };
  EXPECT_NE(refused("*CLOAD\n2, 9, 4.\n").find("the direction '9' of a load cannot be read"), std::string::npos);
  EXPECT_NE(refused("*CLOAD\n99, 1, 4.\n"), "");
  EXPECT_NE(refused("*DLOAD\nEVERYTHING, GRAV, 9.81, 0., 0., 0.\n").find("GRAV has no direction"), std::string::npos);
  const auto nowhere = refused("*DLOAD\nNOWHERE, GRAV, 9.81, 0., 0., -1.\n");
  EXPECT_NE(nowhere.find("no set of elements 'NOWHERE'"), std::string::npos) << nowhere;
  EXPECT_NE(refused("*DLOAD\nCUBE, P, 4.\n").find("has no face for the load P"), std::string::npos);
  EXPECT_NE(refused("*DLOAD\nCUBE, CENTRIF, 4.\n").find("CENTRIF has no direction"), std::string::npos);
  EXPECT_NE(refused("*DLOAD\nCUBE, ROTA, 4.\n*CLOAD\n2, 1, 1.\n").find("*DLOAD ROTA is not read"), std::string::npos);
}

/// Without load cases such a deck stays readable, and what holds is told.
TEST(AbaqusLoads, ArePassedOverUnlessWanted) {
  const auto text = abaqus_bodies + step("*BOUNDARY\n2, 1, 1, 0.01\n*CLOAD\n99, 1, 4.\n");
  const auto deck = parse_abaqus(text, "deck.inp", {});
  EXPECT_TRUE(deck.load_cases.empty());
  EXPECT_TRUE(test::has_note(deck, "a prescribed motion is read as fixed"));
}

// --- Nastran ---------------------------------------------------------------------------------------------------------

/// A unit cube of nodes 1 to 8, held at x = 0, and a plate of nodes 11 to 14 in the plane z = 2.
const std::string nastran_bodies =
    "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,1.,0.\nGRID,4,,0.,1.,0.\nGRID,5,,0.,0.,1.\nGRID,6,,1.,0.,1.\nGRID,"
    "7,,"
    "1.,1.,1.\nGRID,8,,0.,1.,1.\nGRID,11,,0.,0.,2.\nGRID,12,,1.,0.,2.\nGRID,13,,1.,1.,2.\nGRID,14,,0.,1.,2.\n"
    "CHEXA,1,1,1,2,3,4,5,6\n,7,8\nPSOLID,1,1\nCQUAD4,2,2,11,12,13,14\nPSHELL,2,1,.01,1,,1\nMAT1,1,1000.,,0.,2.\n"
    "SPC1,3,123,1,4,5,8\nSPC1,3,123456,11,12,14\nCORD2R,7,,0.,0.,0.,0.,0.,1.\n,0.,1.,0.\n";

TEST(NastranLoads, AreOneCaseASubcase) {
  const std::string control =
      "SOL 101\nCEND\nSPC = 3\nSUBCASE 4\nLOAD = 10\nSUBCASE 5\nLOAD = 30\nSUBCASE 6\nMETHOD = 1\nBEGIN BULK\n";
  const auto deck = nastran(control + nastran_bodies +
                            "FORCE,10,2,,2.,1.,0.,3.\nFORCE,20,3,7,5.,1.,0.,0.\nMOMENT,20,13,,4.,0.,0.,1.\n"
                            "LOAD,30,2.,1.,10,-1.,20\nENDDATA\n");
  ASSERT_EQ(deck.load_cases.size(), 2u);
  expect_near(total(deck, "subcase4"), {2, 0, 6});
  expect_near(total(deck, "subcase5"), {4, -10, 12});  // x of system 7 is y
  EXPECT_DOUBLE_EQ(nodal_forces(deck.model, case_named(deck, "subcase5"))[6 * 10 + 5], -8.0);
}

TEST(NastranLoads, AreOneCaseASetWithoutCaseControl) {
  const auto deck = nastran(nastran_bodies + "FORCE,10,2,,2.,1.\nFORCE,20,2,,3.,1.\nLOAD,30,1.,1.,10\n");
  ASSERT_EQ(deck.load_cases.size(), 2u);
  expect_near(total(deck, "load20"), {3, 0, 0});
  expect_near(total(deck, "load30"), {2, 0, 0});
}

TEST(NastranLoads, PressIntoSolidsAndAlongNormalsOfShells) {
  const auto load = [](const std::string& card) { return total(nastran(nastran_bodies + card), "load1"); };
  expect_near(load("PLOAD4,1,1,3.,,,,1,3\n"), {0, 0, 3});
  expect_near(load("PLOAD4,1,1,3.,,,,5,7\n"), {0, 0, -3});
  expect_near(load("PLOAD4,1,1,3.,3.,3.,3.,6,3\n"), {-3, 0, 0});
  expect_near(load("PLOAD4,1,2,3.\n"), {0, 0, 3});
  expect_near(load("PLOAD2,1,3.,2\n"), {0, 0, 3});
  const auto no_face = problem(nastran, nastran_bodies + "PLOAD4,1,1,3.,,,,1,7\n");
  EXPECT_NE(no_face.find("acts on no face"), std::string::npos) << no_face;
  const auto traction = problem(nastran, nastran_bodies + "PLOAD4,1,1,3.,,,,1,3\n,,1.,0.,0.\n");
  EXPECT_NE(traction.find("traction"), std::string::npos) << traction;
}

/// Triangles by G1 alone or by the corner that is not on the face.
TEST(NastranLoads, PressOnFacesOfTetrahedra) {
  const std::string tetrahedron =
      "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nGRID,4,,0.,0.,1.\n"
      "CTETRA,1,1,1,2,3,4\nPSOLID,1,1\nMAT1,1,1000.,,0.,2.\nSPC1,3,123,1,2,3\n";
  expect_near(total(nastran(tetrahedron + "PLOAD4,1,1,3.,,,,1,4\n"), "load1"), {0, 0, 1.5});
  expect_near(total(nastran(tetrahedron + "PLOAD4,1,1,3.,,,,1,2\n"), "load1"), {1.5, 0, 0});
}

TEST(NastranLoads, WeighByGravity) {
  const auto deck = nastran(nastran_bodies + "GRAV,1,7,9.81,2.,0.,0.\n");
  expect_near(case_named(deck, "load1").gravity, {0, 2 * 9.81, 0});
}

TEST(NastranLoads, MoveSupports) {
  const std::string control = "SOL 101\nCEND\nSPC = 3\nSUBCASE 1\nSUBCASE 2\nLOAD = 9\nBEGIN BULK\n";
  const auto deck =
      nastran(control + nastran_bodies +
              "SPC,3,2,1,.01,3,1,.01\nSPC,3,6,1,.01,7,1,.01\nSPCD,9,2,1,.03,3,1,.03\nSPCD,9,6,1,.03,7,1,.03\n"
              "ENDDATA\n");
  EXPECT_NEAR(displacement(deck, "subcase1", 1).x(), 0.01, 1e-15);
  EXPECT_NEAR(displacement(deck, "subcase2", 1).x(), 0.03, 1e-15);
  EXPECT_FALSE(test::has_note(deck, "fixed at zero"));
  EXPECT_TRUE(test::has_note(parse_nastran(nastran_bodies + "SPC,3,2,1,.01\n", "deck.bdf"), "fixed at zero"));
}

/// Node 2 is moved along its own first axis, [0, 0.6, 0.8], and held along its second one, -x.
TEST(NastranLoads, MoveSupportsAlongTheAxesOfTheirNode) {
  std::string text = nastran_bodies + "CORD2R,8,,0.,0.,0.,0.,-.8,.6\n,0.,.6,.8\nSPC1,3,2,2\n";
  text.replace(text.find("GRID,2,,1.,0.,0."), 16, "GRID,2,,1.,0.,0.,8");
  const std::string control = "SOL 101\nCEND\nSPC = 3\nSUBCASE 1\nSUBCASE 2\nLOAD = 9\nBEGIN BULK\n";
  const auto deck = nastran(control + text + "SPC,3,2,1,.01\nSPCD,9,2,1,.03\nENDDATA\n");
  for (const auto& [subcase, value] : {std::pair{"subcase1", 0.01}, {"subcase2", 0.03}}) {
    const auto moved = displacement(deck, subcase, 1);
    EXPECT_NEAR(0.6 * moved.y() + 0.8 * moved.z(), value, 1e-15);
    EXPECT_NEAR(moved.x(), 0.0, 1e-15);
    EXPECT_LT(solve_statics(deck.model, case_named(deck, subcase)).imbalance, 1e-9);
  }
}

}  // namespace
}  // namespace kalfem
