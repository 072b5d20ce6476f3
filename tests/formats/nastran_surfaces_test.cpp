// SPDX-License-Identifier: Apache-2.0
// Shells and solids of Nastran decks; E = 7e10, nu = 0.3, rho = 2700.
#include <gtest/gtest.h>

#include "formats/nastran_decks.hpp"

namespace kalfem {
namespace {

using test::aluminium;
using test::displacements;
using test::frequencies;

/// A strip 1 x 0.2 of ten quadrilaterals, clamped at x = 0.
std::string strip(const std::string& fields = "") {
  std::string text = "SPC1,1,123456,1,12\n";
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i <= 10; ++i)
      text += "GRID," + std::to_string(11 * j + i + 1) + ",," + std::to_string(0.1 * i) + "," +
              std::to_string(0.2 * j) + "\n";
  for (int i = 1; i <= 10; ++i)
    text += "CQUAD4," + std::to_string(i) + ",1," + std::to_string(i) + "," + std::to_string(i + 1) + "," +
            std::to_string(i + 12) + "," + std::to_string(i + 11) + fields + "\n";
  return text;
}

TEST(NastranShells, HaveMassAndStiffnessOfPshell) {
  const auto deck = test::nastran(aluminium + strip() + "PSHELL,1,1,.01,1,,1,,5.\n");
  ASSERT_TRUE(std::holds_alternative<ShellProperty>(deck.model.properties.at("pshell1")));
  EXPECT_NEAR(test::masses(deck.model).mass, 0.2 * (27.0 + 5.0), 3e-14);  // rounding
  // A narrow plate in bending: between the beam (E) and the strip in plane strain (E / (1 - nu^2)).
  const double tip = displacements(deck.model, {{{10, 2}, 0.5}, {{21, 2}, 0.5}})[62];
  const double beam = 1.0 / (3.0 * 7e10 * 0.2 * 1e-6 / 12.0);
  EXPECT_LT(tip, 1.001 * beam);
  EXPECT_GT(tip, 0.91 * beam);
}

TEST(NastranShells, AreTheSameByPlies) {
  const auto shell = frequencies(test::nastran(aluminium + strip() + "PSHELL,1,1,.01,1,,1\n").model, 5);
  const auto one = frequencies(test::nastran(aluminium + strip() + "PCOMP,1\n,1,.01,0.\n").model, 5);
  // the modes are iterated to 1e-10: found 6e-11
  EXPECT_NEAR((one - shell).norm(), 0.0, 1e-9 * shell.norm());
  const auto half =
      frequencies(test::nastran(aluminium + strip() + "PCOMP,1,,,,,,,SYM\n,1,.0025,0.,,,,30.\n").model, 5);
  EXPECT_NEAR((half - shell).norm(), 0.0, 1e-9 * shell.norm());
  const auto global =
      frequencies(test::nastran(aluminium + strip() + "PCOMPG,1\n,101,1,.004,0.\n,102,1,.006,45.\n").model, 5);
  EXPECT_NEAR((global - shell).norm(), 0.0, 1e-9 * shell.norm());
  // Separate bending material and ratio: the same numbers by another way.
  const auto separate = frequencies(
      test::nastran(aluminium + "MAT1,2,3.5E10,,.3,2700.\n" + strip() + "PSHELL,1,1,.01,2,2.,1\n").model, 5);
  EXPECT_NEAR((separate - shell).norm(), 0.0, 1e-9 * shell.norm());
}

TEST(NastranShells, HaveMaterialAxes) {
  const std::string plies = "MAT8,1,1.E11,1.E10,.3,5.E9,5.E9,5.E9,1600.\nPCOMP,1\n,1,.01,";
  const auto along = frequencies(test::nastran(plies + "0.\n" + strip()).model, 1);
  const auto across = frequencies(test::nastran(plies + "90.\n" + strip()).model, 1);
  // a narrow strip feels its modulus along alone, to 1.3e-4
  EXPECT_NEAR(along[0] / across[0], std::sqrt(10.0), 4e-4 * std::sqrt(10.0));
  // THETA of the element adds to the ply's angle; a system's x axis does as well.
  // found 1e-9: modes are iterated to 1e-10 of the eigenvalue with its shift
  EXPECT_NEAR(frequencies(test::nastran(plies + "0.\n" + strip(",90.")).model, 1)[0], across[0], 1e-8 * across[0]);
  EXPECT_NEAR(frequencies(test::nastran(plies + "60.\n" + strip(",30.")).model, 1)[0], across[0], 1e-8 * across[0]);
  const std::string system = "CORD2R,3,0,0.,0.,0.,0.,0.,1.\n,0.,1.,0.\n";
  EXPECT_NEAR(frequencies(test::nastran(system + plies + "0.\n" + strip(",3")).model, 1)[0], across[0],
              1e-8 * across[0]);
}

TEST(NastranShells, StandOffTheirNodes) {
  // A pull at the nodes of an eccentric strip bends it upwards: P e L^2 / (2 E I).
  const auto deck = test::nastran(aluminium + strip(",,.005") + "PSHELL,1,1,.01,1,,1\n");
  const double tip = displacements(deck.model, {{{10, 0}, 500.0}, {{21, 0}, 500.0}})[62];
  const double beam = 1000.0 * 0.005 / (2.0 * 7e10 * 0.2 * 1e-6 / 12.0);
  EXPECT_NEAR(tip, beam, 0.02 * beam);  // the clamped end holds its width: found .8 %
  const auto plies = test::nastran(aluminium + strip() + "PCOMP,1,0.\n,1,.01,0.\n");
  EXPECT_NEAR(displacements(plies.model, {{{10, 0}, 500.0}, {{21, 0}, 500.0}})[62], tip, 1e-10 * tip);
}

TEST(NastranShells, ThatDifferAreRegionsOfTheirOwn) {
  auto text = aluminium + strip() + "PSHELL,1,1,.01,1,,1\n";
  text +=
      "GRID,23,,0.,-.1\nCTRIA3,11,1,1,2,23\n,,,.02,.02,.02\nCTRIA3,12,1,2,3,23\n,,1,3.,3.,3.\nCTRIA3,13,1,3,4,23\n,,,."
      "01,.02,.03\n";
  const auto deck = test::nastran(text);
  // rounding
  EXPECT_NEAR(std::get<ShellProperty>(deck.model.properties.at("pshell1.2")).thickness, 0.02, 1e-17);
  EXPECT_NEAR(std::get<ShellProperty>(deck.model.properties.at("pshell1.3")).thickness, 0.03, 1e-17);
  EXPECT_EQ(deck.model.mesh.regions.at("pshell1.2").size(), 2u);  // the mean of .01 .02 .03 is the same
  EXPECT_TRUE(test::has_note(deck, "thicknesses at their corners"));
  EXPECT_TRUE(validate(deck.model).empty());
}

TEST(NastranShells, OfSecondOrderBecomeLinear) {
  const auto deck = test::nastran(
      aluminium +
      "PSHELL,1,1,.1,1,,1\nGRID,1\nGRID,2,,2.\nGRID,3,,2.,2.\nGRID,4,,0.,2.\nGRID,5,,1.\nGRID,6,,2.,1.\nGRID,7,,1.,2."
      "\nGRID,8,,0.,1.\n"
      "GRID,9,,3.,1.\nGRID,10,,2.5,.5\nGRID,11,,2.5,1.5\nCQUAD8,1,1,1,2,3,4,5,6\n,7,8\nCTRIA6,2,1,2,9,3,10,11,6\n");
  EXPECT_EQ(deck.model.mesh.cells.size() >= 8u, true);
  EXPECT_NEAR(test::masses(deck.model).mass, 270.0 * 5.0, 1e-11);  // rounding
  EXPECT_TRUE(test::has_note(deck, "replaced by four linear ones"));
}

/// A unit cube by each kind of solid: its mass, its centre and six motions without strain, the next stiff.
void expect_cube(const std::string& cells, double volume) {
  std::string text = aluminium + "PSOLID,1,1\n";
  for (int i = 0; i < 27; ++i)
    text += "GRID," + std::to_string(i + 1) + ",," + std::to_string(0.5 * (i % 3)) + "," +
            std::to_string(0.5 * (i / 3 % 3)) + "," + std::to_string(0.5 * (i / 9)) + "\n";
  const auto deck = test::nastran(text + cells);
  EXPECT_TRUE(validate(deck.model).empty()) << cells;
  const auto mass = test::masses(deck.model);
  EXPECT_NEAR(mass.mass, 2700.0 * volume, 5e-11) << cells;  // rounding
  const auto found = frequencies(deck.model, 7);
  EXPECT_EQ(found[5], 0.0) << cells;
  // A cube of metal of 1 m: between soft patterns of a lone element with few points and the stiffness of a coarse one.
  // Found 118 to 1420 Hz, by kind.
  EXPECT_GT(found[6], 100.0) << cells;
  EXPECT_LT(found[6], 2000.0) << cells;
}

TEST(NastranSolids, AreReadInAllShapes) {
  expect_cube("CHEXA,1,1,1,3,9,7,19,21\n,27,25\n", 1.0);
  expect_cube("CHEXA,1,1,1,7,9,3,19,25\n,27,21\n", 1.0);  // the faces the other way round
  expect_cube("CHEXA,1,1,1,3,9,7,19,21\n,27,25,2,6,8,4,10,12\n,18,16,20,24,26,22\n", 1.0);
  expect_cube("CHEXA,1,1,1,7,9,3,19,25\n,27,21,4,8,6,2,10,16\n,18,12,22,26,24,20\n", 1.0);
  expect_cube("CPENTA,1,1,1,3,7,19,21,25\n", 0.5);
  expect_cube("CPENTA,1,1,1,3,7,19,21,25\n,2,5,4,10,12,16,20,23\n,22\n", 0.5);
  expect_cube("CPENTA,1,1,1,7,3,19,25,21\n,4,5,2,10,16,12,22,23\n,20\n", 0.5);
  expect_cube("CTETRA,1,1,1,3,7,19\n", 1.0 / 6.0);
  expect_cube("CTETRA,1,1,1,7,3,19,4,5\n,2,10,13,11\n", 1.0 / 6.0);
  expect_cube("CTETRA,1,1,1,3,7,19,2,5\n,4,10,11,13\n", 1.0 / 6.0);
  expect_cube("CPYRAM,1,1,1,3,9,7,19\n", 1.0 / 3.0);
}

TEST(NastranSolids, MayBeAnisotropic) {
  // MAT9 of an isotropic material in axes that are turned: the same.
  const double e = 7e10, nu = 0.3, lame = e * nu / ((1 + nu) * (1 - 2 * nu)), g = e / (2 * (1 + nu));
  const auto n = [](double value) { return std::to_string(value); };
  const std::string a = n(lame + 2 * g), b = n(lame), c = n(g);
  const std::string mat9 = "MAT9,2," + a + "," + b + "," + b + ",,,," + a + "\n," + b + ",,,," + a + ",,,\n," + c +
                           ",,," + c + ",," + c + ",2700.\n";
  const std::string nodes =
      "GRID,1\nGRID,2,,1.\nGRID,3,,1.,1.\nGRID,4,,0.,1.\nGRID,5,,0.,0.,1.\nGRID,6,,1.,0.,1.\nGRID,7,,1.,1.,1.\nGRID,8,,"
      "0.,1.,1.\n"
      "CHEXA,1,1,1,2,3,4,5,6\n,7,8\nCORD2R,3,0,0.,0.,0.,1.,1.,1.\n,1.,0.,0.\n";
  const auto isotropic = frequencies(test::nastran(aluminium + nodes + "PSOLID,1,1\n").model, 12);
  const auto turned = frequencies(test::nastran(mat9 + nodes + "PSOLID,1,2,3\n").model, 12);
  EXPECT_NEAR((isotropic - turned).norm(), 0.0, 1e-14 * isotropic.norm());  // rounding
}

/// Turns about the normal of a plate are held by PARAM K6ROT alone: a shaft that stands on it turns almost freely.
TEST(NastranShells, HardlyHoldTurnsAboutTheirNormal) {
  const auto turn = [](const std::string& factor) {
    const auto deck = test::nastran(aluminium + strip() +
                                    "PSHELL,1,1,.01,1,,1\nGRID,99,,.5,0.,.3\nPBAR,2,1,1.E-4,1.E-9,1.E-9,2.E-9\n" +
                                    "CBAR,99,2,99,6,1.,0.,0.\nPARAM,K6ROT," + factor + "\n");
    EXPECT_TRUE(test::has_note(deck, "K6ROT"));
    EXPECT_TRUE(validate(deck.model).empty());
    return displacements(deck.model, {{{22, 5}, 1.0}})[6 * 22 + 5];
  };
  // G t A / 4 of the two plates at the node, in series with the shaft and the plates' own yielding.
  const double g = 7e10 / 2.6, plates = 1e-6 * g * 0.01 * 2.0 * 0.02 / 4.0;
  const double soft = turn("100."), hard = turn("1.E4");
  EXPECT_NEAR(soft - hard, 1.0 / (100.0 * plates) - 1.0 / (1e4 * plates), 1e-13 * soft);  // rounding
}

TEST(NastranShells, AreToldWhatTheyLack) {
  const std::string nodes = "GRID,1\nGRID,2,,1.\nGRID,3,,1.,1.\nCTRIA3,1,1,1,2,3\n";
  EXPECT_NE(test::nastran_problem(nodes + "PSHELL,1,1,,1,,1\n" + aluminium).find("no positive thickness"),
            std::string::npos);
  EXPECT_NE(test::nastran_problem(nodes + "PSHELL,1,,.1\n" + aluminium).find("neither MID1 nor MID2"),
            std::string::npos);
  EXPECT_NE(test::nastran_problem(nodes + "PROD,1,1,.1\n" + aluminium).find("has a PROD as its property"),
            std::string::npos);
  EXPECT_NE(test::nastran_problem(nodes + "PCOMP,1\n").find("no plies"), std::string::npos);
}

}  // namespace
}  // namespace kalfem
