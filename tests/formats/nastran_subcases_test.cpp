// SPDX-License-Identifier: Apache-2.0
// What the subcases of a Nastran deck choose: supports, constraints, temperatures and the preload of its modes.
#include <gtest/gtest.h>

#include "formats/nastran_decks.hpp"
#include "kalfem/model/statics/geometric_stiffness.hpp"
#include "kalfem/model/statics/statics.hpp"

namespace kalfem {
namespace {

/// Four grid points in a row on springs of 100 N/m along x between them; 1 and 4 may be held.
const std::string row =
    "GRID,1,,0.,0.,0.,,23456\nGRID,2,,1.,0.,0.,,23456\nGRID,3,,2.,0.,0.,,23456\nGRID,4,,3.,0.,0.,,23456\n"
    "CELAS2,1,100.,1,1,2,1\nCELAS2,2,100.,2,1,3,1\nCELAS2,3,100.,3,1,4,1\nCONM2,11,2,,1.\n"
    "SPC1,1,1,1\nSPC1,2,1,4\nFORCE,7,2,,6.,1.\nMPC,8,2,1,1.,3,1,-1.\n";

Deck read(const std::string& control, const std::string& bulk = row,
          const DeckOptions& options = {.load_cases = true}) {
  return parse_nastran(control + "BEGIN BULK\n" + bulk + "ENDDATA\n", "deck.bdf", {}, options);
}

std::string problem(const std::string& control, const std::string& bulk = row,
                    const DeckOptions& options = {.load_cases = true}) {
  try {
    read(control, bulk, options);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

const DeckNote* find_note(const Deck& deck, const std::string& what) {
  const auto found = std::ranges::find(deck.notes, what, &DeckNote::what);
  return found == deck.notes.end() ? nullptr : &*found;
}

double moved(const Deck& deck, std::size_t load_case, Eigen::Index node) {
  return StaticAnalysis(deck.model, deck.load_cases).solve(load_case).displacements[6 * node];
}

const std::string different_supports = "SOL 101\nCEND\nLOAD = 7\nSUBCASE 1\nSPC = 1\nSUBCASE 2\nSPC = 2\n";

// One spring to the support, or two.
TEST(NastranSubcases, EachHaveTheirOwnSupports) {
  const auto deck = read(different_supports);
  ASSERT_EQ(deck.load_cases.size(), 2u);
  EXPECT_NEAR(moved(deck, 0, 1), 0.06, 1e-14);
  EXPECT_NEAR(moved(deck, 1, 1), 0.12, 1e-14);
  EXPECT_NEAR(moved(deck, 1, 0), 0.12, 1e-14);
  const auto* note = find_note(deck, "the SPC of SUBCASE 2");
  ASSERT_NE(note, nullptr);
  EXPECT_EQ(note->kind, DeckNoteKind::doubtful);
  EXPECT_NE(note->consequence.find("natural modes"), std::string::npos);
}

/// The same with the grid points in turned axes, whose x is the basic y.
TEST(NastranSubcases, HoldPointsInTurnedAxes) {
  std::string turned = row + "CORD2R,9,,0.,0.,0.,0.,0.,1.\n,0.,1.,0.\n";
  for (const char* grid : {"GRID,1,,0.,0.,0.,", "GRID,2,,1.,0.,0.,", "GRID,3,,2.,0.,0.,", "GRID,4,,3.,0.,0.,"})
    turned.insert(turned.find(grid) + std::string(grid).size(), "9");
  turned.replace(turned.find("FORCE,7,2,,6."), 13, "FORCE,7,2,9,6.");
  const auto deck = read(different_supports, turned);
  ASSERT_EQ(deck.load_cases.size(), 2u);
  const auto first = StaticAnalysis(deck.model, deck.load_cases).solve(0),
             second = StaticAnalysis(deck.model, deck.load_cases).solve(1);
  EXPECT_NEAR(first.displacements[7], 0.06, 1e-14);
  EXPECT_NEAR(second.displacements[7], 0.12, 1e-14);
}

TEST(NastranSubcases, ThatDifferAskWhichOneIsMeant) {
  const auto deck = read(different_supports, row, {});
  const auto* note = find_note(deck, "the SPC of SUBCASE 2");
  ASSERT_NE(note, nullptr);
  EXPECT_EQ(note->kind, DeckNoteKind::missing);
  EXPECT_NE(note->consequence.find("`subcase: 2`"), std::string::npos);
  const auto chosen = read(different_supports, row, {.subcase = 2});
  EXPECT_EQ(find_note(chosen, "the SPC of SUBCASE 2"), nullptr);
  EXPECT_EQ(chosen.model.fixed.front().name, "spc2");
  EXPECT_NE(problem(different_supports, row, {.subcase = 5}).find("no SUBCASE 5"), std::string::npos);
}

TEST(NastranSubcases, WithMethodAreThoseOfTheModes) {
  const std::string control = "SOL 103\nCEND\nSUBCASE 1\nSPC = 1\nLOAD = 7\nSUBCASE 2\nSPC = 2\nMETHOD = 3\n";
  const auto deck = read(control, row, {});
  EXPECT_EQ(deck.model.fixed.front().name, "spc2");
  EXPECT_EQ(find_note(deck, "the SPC of SUBCASE 1"), nullptr);
}

TEST(NastranSubcases, WithAnotherMpcAreRefused) {
  const std::string control = "SOL 101\nCEND\nSPC = 1\nLOAD = 7\nSUBCASE 1\nSUBCASE 2\nMPC = 8\n";
  const auto message = problem(control);
  EXPECT_NE(message.find("SUBCASE 2: its MPC is another one than that of SUBCASE 1"), std::string::npos) << message;
  EXPECT_NE(message.find("`subcase: 2`"), std::string::npos) << message;
  const auto deck = read(control, row, {.subcase = 2, .load_cases = true});
  ASSERT_EQ(deck.load_cases.size(), 1u);
  EXPECT_EQ(deck.load_cases.front().name, "subcase2");
  EXPECT_EQ(deck.model.constraints.size(), 1u);
  EXPECT_NE(find_note(read(control, row, {}), "the MPC of SUBCASE 2"), nullptr);
}

TEST(NastranSubcases, WithAnotherTemperatureAreRefused) {
  const std::string bar =
      "GRID,1,,0.,0.,0.,,123456\nGRID,2,,1.,0.,0.,,23456\nCROD,1,1,1,2\nPROD,1,1,1.\nMAT1,1,1.,,.3,1.\nMATT1,1,4\n"
      "TABLEM1,4\n,0.,1000.,100.,500.,ENDT\nTEMPD,5,0.,6,100.\nFORCE,7,2,,1.,1.\n";
  const std::string control = "SOL 101\nCEND\nLOAD = 7\nSUBCASE 1\nTEMP(MATE) = 5\nSUBCASE 2\nTEMP(MATE) = 6\n";
  EXPECT_NE(problem(control, bar).find("SUBCASE 2: its materials have another temperature"), std::string::npos);
  EXPECT_NEAR(moved(read(control, bar, {.subcase = 2, .load_cases = true}), 0, 1), 1.0 / 500.0, 1e-15);
  EXPECT_NEAR(moved(read(control, bar, {.temperature = 0.0, .load_cases = true}), 1, 1), 1.0 / 1000.0, 1e-15);
}

// --- preload ---------------------------------------------------------------------------------------------------------

/// A bar of two CBAR along x, clamped at one end.
const std::string bars =
    "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,2.,0.,0.\nCBAR,1,1,1,2,0.,1.,0.\nCBAR,2,1,2,3,0.,1.,0.\n"
    "PBAR,1,1,1.E-4,1.E-8,1.E-8,1.E-8\nMAT1,1,2.E11,,.3,7800.,1.E-5\nSPC1,5,123456,1\nSPC1,6,123456,1,3\n"
    "FORCE,7,3,,500.,1.\n";

TEST(NastranPreload, IsTheStaticSubcaseOfStatsub) {
  for (const char* command : {"STATSUB = 1", "STATSUB(PRELOAD) = 1", "stat = 1", "STATSUB (PRELOAD) = 1"}) {
    const std::string control = "SOL 103\nCEND\nSUBCASE 1\nSPC = 5\nLOAD = 7\nSUBCASE 2\nSPC = 6\nMETHOD = 9\n";
    const auto deck = read(control + command + "\n", bars, {});
    ASSERT_TRUE(deck.preload.has_value()) << command;
    EXPECT_EQ(deck.preload->name, "subcase1");
    EXPECT_TRUE(deck.load_cases.empty());
    EXPECT_FALSE(test::has_note(deck, "FORCE"));
    EXPECT_EQ(deck.model.fixed.front().name, "spc6");  // while the bar is pulled it is held at one end
    const auto pulled = solve_statics(deck.model, *deck.preload);
    EXPECT_NEAR(pulled.displacements[12], 500.0 * 2.0 / (2e11 * 1e-4), 1e-12);
    // N (v'^2) of a straight line that turns by v' = 1 about the first end.
    Eigen::VectorXd turn = Eigen::VectorXd::Zero(18);
    for (Eigen::Index node = 0; node < 3; ++node)
      turn[6 * node + 1] = static_cast<double>(node), turn[6 * node + 5] = 1.0;
    EXPECT_NEAR(turn.dot(preload_stiffness(deck.model, *deck.preload) * turn), 500.0 * 2.0, 1e-8);
  }
}

TEST(NastranPreload, IsNoneOfBucklingAndOfOtherSubcases) {
  const std::string subcases = "CEND\nSPC = 5\nSUBCASE 1\nLOAD = 7\nSUBCASE 2\nMETHOD = 9\nSTATSUB = 1\n";
  EXPECT_FALSE(read("SOL 105\n" + subcases, bars, {}).preload.has_value());
  EXPECT_TRUE(read("SOL 103\n" + subcases, bars, {}).preload.has_value());
  EXPECT_FALSE(read("SOL 103\n" + subcases, bars, {.subcase = 1}).preload.has_value());
}

TEST(NastranPreload, ThatCannotBeReadIsRefused) {
  const auto refused = [](const std::string& of_static, const std::string& cards) {
    return problem(
        "SOL 103\nCEND\nSPC = 5\nSUBCASE 1\n" + of_static + "\nSUBCASE 2\nMETHOD = 9\nSTATSUB(PRELOAD) = 1\n",
        bars + cards, {});
  };
  for (const auto& message : {refused("TEMP(LOAD) = 8", "TEMPD,8,50.\n"), refused("DEFORM = 8", "DEFORM,8,1,1.E-3\n"),
                              refused("", ""), refused("LOAD = 7\nMPC = 3", "MPC,3,2,1,1.,3,1,-1.\n")}) {
    EXPECT_NE(message.find("preload"), std::string::npos) << message;
    EXPECT_NE(message.find("`subcase`"), std::string::npos) << message;
  }
  const auto unread = refused("LOAD = 8", "ACCEL1,8,,9.81,0.,0.,1.\n,2\n");
  for (const char* part : {"ACCEL1", "`preload`"}) EXPECT_NE(unread.find(part), std::string::npos) << unread;
  const auto nowhere = problem("SOL 103\nCEND\nSPC = 5\nMETHOD = 9\nSTATSUB = 4\n", bars, {});
  EXPECT_NE(nowhere.find("STATSUB = 4 names no SUBCASE"), std::string::npos) << nowhere;
}

/// E 1000 at 0 degrees and 500 at 100, which the static subcase chooses.
TEST(NastranPreload, GivesItsUniformTemperatureToTheMaterials) {
  std::string hot = bars + "MATT1,1,4\nTABLEM1,4\n,0.,1000.,100.,500.,ENDT\nTEMPD,8,100.\n";
  hot.replace(hot.find(",1.E-5"), 6, "");
  const std::string control = "SOL 103\nCEND\nSPC = 5\nSUBCASE 1\nLOAD = 7\n";
  const auto deck = read(control + "TEMP = 8\nSUBCASE 2\nMETHOD = 9\nSTATSUB = 1\n", hot, {});
  EXPECT_DOUBLE_EQ(deck.model.materials.at("mat1").youngs_modulus, 500.0);
  const auto field = problem(control + "TEMP = 8\nSUBCASE 2\nMETHOD = 9\nSTATSUB = 1\n", hot + "TEMP,8,2,90.\n", {});
  EXPECT_NE(field.find("state this `temperature` beside `deck`"), std::string::npos) << field;
}

TEST(NastranSolution, OfAnotherAnalysisIsNamed) {
  const auto named = [](const std::string& solution) { return read(solution + "\nCEND\nSPC = 5\n", bars, {}); };
  EXPECT_TRUE(test::has_note(named("SOL 105"), "SOL 105 (buckling): this analysis is not run"));
  EXPECT_TRUE(test::has_note(named("SOL SEBUCKL"), "SOL SEBUCKL (buckling)"));
  EXPECT_TRUE(test::has_note(named("SOL 111"), "SOL 111 (frequency response)"));
  EXPECT_TRUE(test::has_note(named("SOL 101"), "SOL 101 (statics): the structure is read, and its load cases"));
  EXPECT_FALSE(test::has_note(named("SOL 103"), "SOL 103"));
  EXPECT_TRUE(named("SOL 101").is_static_analysis);
  EXPECT_FALSE(named("SOL 103").is_static_analysis);
}

}  // namespace
}  // namespace kalfem
