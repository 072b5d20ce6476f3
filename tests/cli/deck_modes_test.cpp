// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <numbers>

#include "command.hpp"

namespace kalfem::test {
namespace {

/// Two masses of 2 kg and 1 kg on springs of 800 and 200 N/m in a row, along x.
const std::string two_masses = R"(SOL 103
BEGIN BULK
GRID,1,,0.,0.,0.,,123456
GRID,2,,1.,0.,0.,,23456
GRID,3,,2.,0.,0.,,23456
CELAS2,1,800.,1,1,2,1
CELAS2,2,200.,2,1,3,1
CONM2,11,2,,2.
CONM2,12,3,,1.
ENDDATA
)";

/// Roots of det(K - w^2 M) = 2 w^4 - 1400 w^2 + 160000.
double frequency(int mode) {
  const double root = std::sqrt(1400.0 * 1400.0 - 8.0 * 160000.0);
  return std::sqrt((1400.0 + (mode == 1 ? -root : root)) / 4.0) / (2.0 * std::numbers::pi);
}

TEST(DeckModes, AreThoseOfTheWholeDeck) {
  const ScratchFolder folder("deck-modes-alone");
  const std::string deck = (folder / "two.bdf").string();
  std::ofstream(deck) << two_masses;
  const auto outcome = run_command("modes " + deck + " --modes 2 --json", folder);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const auto json = nlohmann::json::parse(outcome.output);
  ASSERT_EQ(json["frequencies_hz"].size(), 2U);
  for (int mode : {1, 2}) EXPECT_NEAR(json["frequencies_hz"][mode - 1].get<double>(), frequency(mode), 1e-9);
  EXPECT_EQ(json["dofs"], 2);
  const auto table = run_command("modes " + deck + " --modes 2 --out " + (folder / "out").string(), folder);
  ASSERT_EQ(table.code, 0) << table.errors;
  EXPECT_NE(table.output.find("frequency [Hz]"), std::string::npos) << table.output;
  EXPECT_TRUE(std::filesystem::exists(folder / "out" / "two_modes.vtu"));
  EXPECT_EQ(run_command("modes " + deck + " --modes 2", folder).code, 0);
  EXPECT_FALSE(std::filesystem::exists(folder / "two.kalfem-out"));
}

// In tonnes, millimetres and seconds stiffness has the number of N/mm.
TEST(DeckModes, CountTheUnits) {
  const ScratchFolder folder("deck-modes-units");
  const std::string deck = (folder / "two.bdf").string();
  std::ofstream(deck) << two_masses;
  const auto outcome = run_command("modes " + deck + " --units mm t s --modes 2 --json", folder);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const auto json = nlohmann::json::parse(outcome.output);
  EXPECT_NEAR(json["frequencies_hz"][0].get<double>(), frequency(1), 1e-9);
  EXPECT_NEAR(json["mass"].get<double>(), 3000.0, 1e-9);
  EXPECT_EQ(run_command("modes " + deck + " --units mm t", folder).code, 2);
  EXPECT_EQ(run_command("modes " + deck + " --set a=1", folder).code, 2);
}

/// Steel beams in mm, t and s from grid 1 to `grids`.
std::string steel_beams(int grids, const std::string& more = "") {
  std::string deck = "SOL 103\nBEGIN BULK\nMAT1,1,2.1+5,,.3,7.85-9\nPBAR,1,1,100.,833.,833.,1406.\n";
  for (int grid = 1; grid <= grids; ++grid)
    deck += "GRID," + std::to_string(grid) + ",," + std::to_string(100 * grid) + ".,0.,0." +
            (grid == 1 ? ",,123456\n" : "\n");
  for (int grid = 1; grid < grids; ++grid)
    deck +=
        "CBAR," + std::to_string(grid) + ",1," + std::to_string(grid) + "," + std::to_string(grid + 1) + ",0.,0.,1.\n";
  return deck + more + "ENDDATA\n";
}

Outcome modes_of(const std::string& text, const ScratchFolder& folder, const std::string& options = "") {
  const std::string deck = (folder / "beams.bdf").string();
  std::ofstream(deck) << text;
  return run_command("modes " + deck + " --modes 2 " + options, folder);
}

TEST(DeckModes, WarnOfUnitsThatAreNotDeclared) {
  const ScratchFolder folder("deck-modes-other-units");
  const auto outcome = modes_of(steel_beams(4), folder);
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_NE(outcome.errors.find("in mm, t, s (N, MPa)"), std::string::npos) << outcome.errors;
  EXPECT_EQ(modes_of(steel_beams(4), folder, "--units mm t s").errors, "");
}

// The fifth grid hangs on a spring along x alone.
TEST(DeckModes, TellOfUnitsBeforeMechanisms) {
  const ScratchFolder folder("deck-modes-mechanism");
  const std::string hanging =
      steel_beams(4, "PARAM,AUTOSPC,NO\nGRID,5,,500.,0.,0.,,456\nCELAS2,9,1.,4,1,5,1\nCONM2,10,5,,1.-3\n");
  const auto outcome = modes_of(hanging, folder);
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.errors.find("declare the units: length mm, mass t, time s"), std::string::npos) << outcome.errors;
  EXPECT_EQ(outcome.errors.find("mechanism"), std::string::npos) << outcome.errors;
  const auto declared = modes_of(hanging, folder, "--units mm t s");
  EXPECT_EQ(declared.code, 2);
  EXPECT_NE(declared.errors.find("it moves without strain at n5.y, n5.z"), std::string::npos) << declared.errors;
}

TEST(DeckModes, WarnOfCoincidentElementsOnce) {
  const ScratchFolder folder("deck-modes-coincident");
  const auto outcome =
      modes_of(steel_beams(4, "CBAR,11,1,1,2,0.,0.,1.\nCBAR,12,1,3,2,0.,0.,1.\n"), folder, "--units mm t s");
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_NE(outcome.errors.find("2 pairs of elements have the same nodes: line 1 and line 11, line 2 and line 12"),
            std::string::npos)
      << outcome.errors;
}

TEST(DeckModes, RefuseWhatTheDeckNeedsAndKalfemDoesNotRead) {
  const ScratchFolder folder("deck-modes-missing");
  const std::string deck = (folder / "two.bdf").string();
  std::string text = two_masses;
  std::ofstream(deck) << text.replace(text.find("CONM2,11"), 0, "CWELD,9,1,2\n");
  const auto outcome = run_command("modes " + deck, folder);
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.errors.find("CWELD"), std::string::npos) << outcome.errors;
  EXPECT_EQ(run_command("modes " + (folder / "none.bdf").string(), folder).code, 2);
}

}  // namespace
}  // namespace kalfem::test
