// SPDX-License-Identifier: Apache-2.0
// Loads of Nastran beside forces, pressures and gravity: by closed forms of one beam, and refused where they are not
// read.
#include <gtest/gtest.h>

#include <numbers>

#include "formats/nastran_decks.hpp"
#include "kalfem/model/statics/statics.hpp"
#include "kalfem/model/statics/stresses.hpp"

namespace kalfem {
namespace {

using Eigen::Vector3d;

constexpr double length = 2.0, modulus = 2e11, area = 1e-4, i1 = 1e-8, i2 = 2e-8, torsion = 3e-8;
constexpr double shear_modulus = modulus / 2.6;

/// A cantilever of one CBAR along x; plane 1 is x-y.
const std::string cantilever =
    "GRID,1,,0.,0.,0.\nGRID,2,,2.,0.,0.\nGRID,3,,0.,1.,0.\nGRID,4,,0.,0.,3.\nSPC1,5,123456,1,3,4\n"
    "CBAR,1,1,1,2,0.,1.,0.\nPBAR,1,1,1.E-4,1.E-8,2.E-8,3.E-8\nMAT1,1,2.E11,,.3,7800.,1.E-5\n";

Deck read(const std::string& text) { return parse_nastran(text, "deck.bdf", {}, {.load_cases = true}); }

std::string problem(const std::string& text) {
  try {
    read(text);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

LoadCase only_case(const Deck& deck) {
  if (deck.load_cases.size() != 1) throw std::logic_error("there are several load cases, or none");
  return deck.load_cases.front();
}

/// Motions of grid 2.
Eigen::VectorXd tip(const std::string& card) {
  const auto deck = read(cantilever + card);
  return solve_statics(deck.model, only_case(deck)).displacements.segment(6, 6);
}

/// Force and moment at a grid point, by its place among the nodes.
Eigen::VectorXd load_at(const std::string& card, Eigen::Index node) {
  const auto deck = read(cantilever + card);
  return nodal_forces(deck.model, only_case(deck)).segment(6 * node, 6);
}

Vector3d total(const std::string& card) {
  const auto deck = read(cantilever + card);
  const auto forces = nodal_forces(deck.model, only_case(deck));
  Vector3d sum = Vector3d::Zero();
  for (Eigen::Index node = 0; node < deck.model.mesh.node_count(); ++node) sum += forces.segment<3>(6 * node);
  return sum;
}

void expect_near(const Eigen::VectorXd& found, const Eigen::VectorXd& expected) {
  EXPECT_LE((found - expected).norm(), 1e-10 * expected.norm())
      << found.transpose() << " instead of " << expected.transpose();
}

TEST(NastranForces, HaveTheDirectionOfTheirGridPoints) {
  Eigen::VectorXd expected = Eigen::VectorXd::Zero(6);
  expected[1] = 7.0;
  expect_near(load_at("FORCE1,9,2,7.,1,3\n", 1), expected);
  expected << 0, 0, 0, 0, -4.0, 0;
  expect_near(load_at("MOMENT1,9,2,-4.,1,3\n", 1), expected);
  expected << 0, -5.0, 0, 0, 0, 0;  // x cross z
  expect_near(load_at("FORCE2,9,2,5.,1,2,1,4\n", 1), expected);
  expected << 0, 0, 0, 3.0, 0, 0;  // y cross z
  expect_near(load_at("MOMENT2,9,2,3.,1,3,1,4\n", 1), expected);
  EXPECT_NE(problem(cantilever + "FORCE2,9,2,5.,1,2,1,2\n").find("give no direction"), std::string::npos);
  EXPECT_NE(problem(cantilever + "FORCE1,9,2,7.,3,3\n").find("give no direction"), std::string::npos);
}

TEST(NastranForces, ActOnScalarPoints) {
  const auto deck = read("SPOINT,1,2\nCELAS4,1,1000.,1\nCELAS4,2,500.,1,2\nSLOAD,9,2,10.\n");
  const auto moved = solve_statics(deck.model, only_case(deck)).displacements;
  EXPECT_NEAR(moved[0], 0.01, 1e-15);
  EXPECT_NEAR(moved[6], 0.03, 1e-15);
}

TEST(NastranPressures, ActAlongTheNormalOfTheirGridPoints) {
  const std::string plate = "GRID,11,,0.,0.,5.\nGRID,12,,2.,0.,5.\nGRID,13,,2.,3.,5.\nGRID,14,,0.,3.,5.\n";
  expect_near(total(plate + "PLOAD,9,4.,11,12,13,14\n"), Vector3d(0, 0, 24));
  expect_near(total(plate + "PLOAD,9,4.,11,12,13\n"), Vector3d(0, 0, 12));
  expect_near(total(plate + "PLOAD,9,4.,14,13,12,11\n"), Vector3d(0, 0, -24));
}

// Deflections of the free end of a cantilever.
TEST(NastranBeamLoads, DeflectAsTheirClosedFormsSay) {
  const double q = 10.0, p = 30.0, at = 0.5, bending = modulus * i1, other = modulus * i2;
  EXPECT_NEAR(tip("PLOAD1,9,1,FY,LE,0.,10.,2.,10.\n")[1], q * std::pow(length, 4) / (8 * bending), 1e-9);
  EXPECT_NEAR(tip("PLOAD1,9,1,FZE,FR,0.,10.,1.\n")[2], q * std::pow(length, 4) / (8 * other), 1e-9);
  EXPECT_NEAR(tip("PLOAD1,9,1,FY,FR,0.,0.,1.,10.\n")[1], 11 * q * std::pow(length, 4) / (120 * bending), 1e-9);
  EXPECT_NEAR(tip("PLOAD1,9,1,FYE,LE,.5,30.\n")[1], p * at * at * (3 * length - at) / (6 * bending), 1e-9);
  EXPECT_NEAR(tip("PLOAD1,9,1,MZ,FR,.25,30.\n")[1], p * at * (length - at / 2) / bending, 1e-9);
  EXPECT_NEAR(tip("PLOAD1,9,1,FX,LE,.5,30.\n")[0], p * at / (modulus * area), 1e-15);
  EXPECT_NEAR(tip("PLOAD1,9,1,MXE,LE,.5,30.\n")[3], p * at / (shear_modulus * torsion), 1e-12);
  EXPECT_NEAR(tip("PLOAD1,9,1,FY,LE,2.,30.\n")[1], p * std::pow(length, 3) / (3 * bending), 1e-9);
  // A load over the outer half: of all less that of the inner half, q a^3 (4 L - a) / 24.
  EXPECT_NEAR(tip("PLOAD1,9,1,FY,LE,1.,10.,2.,10.\n")[1],
              q * (std::pow(length, 4) / 8 - (4 * length - 1) / 24) / bending, 1e-9);
}

TEST(NastranBeamLoads, LeaveTheMomentsOfTheLoadAtTheEnds) {
  const auto deck = read(cantilever + "PLOAD1,9,1,FY,FR,0.,10.,1.,10.\n");
  const auto load_case = only_case(deck);
  const auto solution = solve_statics(deck.model, load_case);
  const auto regions = recover_stresses(deck.model, solution.displacements, {}, load_case.beam_loads);
  const auto& ends = regions.front().beams.front().ends;
  EXPECT_NEAR(std::abs(ends[0][5]), 10.0 * length * length / 2, 1e-9);  // M_z
  EXPECT_NEAR(ends[1][5], 0.0, 1e-9);
  EXPECT_NEAR(std::abs(ends[0][1]), 10.0 * length, 1e-9);
}

/// Clamped at one end, hinged and held at the other: 5/16 of a force in the middle goes to the hinge.
TEST(NastranBeamLoads, PassHinges) {
  std::string text = cantilever + "SPC1,5,123,2\nPLOAD1,9,1,FY,FR,.5,16.\n";
  text.replace(text.find("CBAR,1,1,1,2,0.,1.,0."), 21, "CBAR,1,1,1,2,0.,1.,0.,\n,,6");
  const auto deck = read(text);
  const auto forces = nodal_forces(deck.model, only_case(deck));
  EXPECT_NEAR(forces[1], 11.0, 1e-9);
  EXPECT_NEAR(forces[5], 3.0 / 16 * 16 * length, 1e-9);
  EXPECT_NEAR(forces[7], 5.0, 1e-9);
  EXPECT_NEAR(forces[11], 0.0, 1e-9);
}

/// Offsets of 1 along z at both ends carry a load along y as a moment about x.
TEST(NastranBeamLoads, ReachTheNodesOverOffsets) {
  std::string text = cantilever + "PLOAD1,9,1,FY,FR,0.,10.,1.\n";
  text.replace(text.find("CBAR,1,1,1,2,0.,1.,0."), 21, "CBAR,1,1,1,2,0.,1.,0.,\n,,,0.,0.,1.,0.,0.,1.");
  const auto deck = read(text);
  const auto forces = nodal_forces(deck.model, only_case(deck));
  EXPECT_NEAR(forces[1] + forces[7], 20.0, 1e-9);
  EXPECT_NEAR(forces[3] + forces[9], -20.0, 1e-9);
}

TEST(NastranBeamLoads, AreRefusedWhereTheyMakeNoSense) {
  EXPECT_NE(problem(cantilever + "PLOAD1,9,7,FY,FR,0.,10.,1.\n").find("no CBAR or CBEAM"), std::string::npos);
  EXPECT_NE(problem(cantilever + "PLOAD1,9,1,FY,LE,0.,10.,3.\n").find("beyond the element"), std::string::npos);
  EXPECT_NE(problem(cantilever + "PLOAD1,9,1,FQ,LE,0.,10.,1.\n").find("TYPE is 'FQ'"), std::string::npos);
  EXPECT_NE(problem(cantilever + "PLOAD1,9,1,FY,LEPR,0.,10.,1.\n").find("PLOAD1 with SCALE LEPR"), std::string::npos);
}

/// The factor 4 of the forces is a factor 2 of the speed.
TEST(NastranRotation, IsThatOfTheCase) {
  const auto turned = only_case(read(cantilever + "RFORCE,9,3,,5.,0.,0.,2.\n")).rotation;
  ASSERT_TRUE(turned.has_value());
  EXPECT_NEAR(turned->speed, 2.0 * std::numbers::pi * 10.0, 1e-12);
  expect_near(turned->axis, Vector3d(0, 0, 1));
  expect_near(turned->about, Vector3d(0, 1, 0));
  const auto summed = only_case(read(cantilever + "RFORCE,9,0,,5.,0.,0.,2.\nLOAD,10,2.,2.,9\n")).rotation;
  EXPECT_NEAR(summed->speed, 2.0 * std::numbers::pi * 20.0, 1e-12);
  EXPECT_NE(problem(cantilever + "RFORCE,9,0,,5.,0.,0.,2.,\n,3.\n").find("RACC"), std::string::npos);
}

/// Two subcases, of which the second holds what is not read.
std::string two_subcases(const std::string& second, const std::string& cards) {
  return "SOL 101\nCEND\nSPC = 5\nSUBCASE 1\nLOAD = 1\nSUBCASE 2\n" + second + "\nBEGIN BULK\n" + cantilever +
         "FORCE,1,2,,5.,0.,1.,0.\n" + cards + "ENDDATA\n";
}

TEST(NastranUnreadLoads, AreRefusedWhereALoadCaseHoldsThem) {
  for (const char* card : {"ACCEL,2,,0.,0.,1.\n", "ACCEL1,2,,9.81,0.,0.,1.\n,2\n", "PLOADX1,2,1,3.,3.,1,2\n"}) {
    const std::string name(card, std::string(card).find(','));
    const auto message = problem(two_subcases("LOAD = 2", card + std::string("FORCE,2,2,,1.,1.\n")));
    EXPECT_NE(message.find("SUBCASE 2 holds " + name + " of set 2"), std::string::npos) << message;
    EXPECT_EQ(problem(two_subcases("LOAD = 3", card + std::string("FORCE,3,2,,1.,1.\n"))), "") << name;
  }
  const auto without_control = problem(cantilever + "FORCE,2,2,,1.,1.\nACCEL1,2,,9.81,0.,0.,1.\n,2\n");
  EXPECT_NE(without_control.find("ACCEL1"), std::string::npos) << without_control;
}

TEST(NastranUnreadLoads, AreRefusedAlone) {
  const auto thermal = problem(two_subcases("TEMPERATURE(LOAD) = 8", "TEMPD,8,50.\n"));
  EXPECT_NE(thermal.find("SUBCASE 2: TEMPERATURE(LOAD) = 8"), std::string::npos) << thermal;
  EXPECT_NE(thermal.find("`subcase`"), std::string::npos) << thermal;
  const auto both = problem(two_subcases("TEMP = 8", "TEMPD,8,50.\n"));
  EXPECT_NE(both.find("TEMPERATURE(LOAD) = 8"), std::string::npos) << both;
  const auto deformed = problem(two_subcases("DEFORM = 8", "DEFORM,8,1,.001\n"));
  EXPECT_NE(deformed.find("DEFORM = 8"), std::string::npos) << deformed;
  const auto no_cards = problem(two_subcases("LOAD = 8", ""));
  EXPECT_NE(no_cards.find("SUBCASE 2: LOAD = 8 selects a set without cards"), std::string::npos) << no_cards;
}

/// Without expansion a temperature is no load.
TEST(NastranUnreadLoads, AreNoneWithoutExpansion) {
  std::string text = two_subcases("TEMP(LOAD) = 8", "TEMPD,8,50.\n");
  text.replace(text.find(",1.E-5"), 6, "");
  const auto deck = read(text);
  EXPECT_EQ(deck.load_cases.size(), 1u);
  EXPECT_TRUE(test::has_note(deck, "TEMPD: no material depends on temperature or expands"));
}

TEST(NastranUnreadLoads, AreToldWhereNoCaseIsWanted) {
  const auto deck = parse_nastran(cantilever + "FORCE1,1,2,7.,1,3\nACCEL,2,,0.,0.,1.\n", "deck.bdf");
  EXPECT_TRUE(test::has_note(deck, "FORCE1: loads are ignored; a case reads them"));
  EXPECT_TRUE(test::has_note(deck, "ACCEL: kalfem does not read this load"));
}

/// One that loads supports alone is solved: it moves nothing, and the supports take it.
TEST(NastranLoads, OnSupportsAloneDoNotRefuseOthers) {
  const auto deck = read(two_subcases("LOAD = 2", "FORCE,2,1,,1.,1.\n"));
  ASSERT_EQ(deck.load_cases.size(), 2u);
  const StaticAnalysis analysis(deck.model, deck.load_cases);
  EXPECT_GT(analysis.solve(0).displacements.norm(), 0.0);
  EXPECT_EQ(analysis.solve(1).displacements.norm(), 0.0);
  EXPECT_NEAR(analysis.solve(1).reaction_sum.force.x(), -1.0, 1e-12);
}

}  // namespace
}  // namespace kalfem
