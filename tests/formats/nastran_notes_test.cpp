// SPDX-License-Identifier: Apache-2.0
// What is read although it is unusual, and of which kind the notes are.
#include <gtest/gtest.h>

#include <algorithm>

#include "formats/nastran_decks.hpp"

namespace kalfem {
namespace {

using test::aluminium;
using test::nastran;
using test::nastran_problem;

const std::string square = "GRID,1\nGRID,2,,1.\nGRID,3,,1.,1.\nGRID,4,,,1.\nGRID,5,,2.\nGRID,6,,2.,1.\n" + aluminium;
const std::string quads = "CQUAD4,1,1,1,2,3,4\nCQUAD4,2,1,2,5,6,3\n";
const std::string shell = "PSHELL,1,1,.01,1,,1\n";

/// The first note that begins so.
const DeckNote* note_of(const Deck& deck, const std::string& beginning) {
  const auto found =
      std::ranges::find_if(deck.notes, [&](const DeckNote& note) { return note.what.starts_with(beginning); });
  return found == deck.notes.end() ? nullptr : &*found;
}

/// What changes the model is told with the number of elements.
TEST(NastranNotes, CountTheElementsThatChange) {
  const std::vector<std::pair<std::string, std::string>> changes = {
      {"PCOMP,1,,,,,,,MEM\n,1,.001,0.,YES\n" + quads, "LAM MEM"},
      {"PSHELL,1,1,.01,1,,1,,,+\n+,,,1\n" + quads, "coupling of stretching"},
      {"PSHELL,1,1,.01,-1,,1\n" + quads, "plane strain"},
      {"PSHELL,1,1,.01,1\n" + quads, "PSHELL without MID3"},
      {"PSHELL,1,1,.01\n" + quads, "PSHELL without MID2"},
      {"PSHELL,1,,.01,1\n" + quads, "PSHELL without MID1"},
      {shell + "CQUAD4,1,1,1,2,3,4,,,+\n+,,,.01,.02,.02,.01\nCQUAD4,2,1,2,5,6,3,,,+\n+,,,.01,.02,.02,.01\n",
       "shells with different thicknesses"},
      {"PSHELL,1,7,.01,7,,7\nMAT1,7,7.E10,,.3,2700.,,,.02\n" + quads, "structural damping (GE)"},
      {"PCOMP,1,,,,,,.02\n,1,.001,0.\n" + quads, "structural damping (GE of PCOMP)"},
      {"PBAR,1,1,1.-3,0.,1.-6,2.-6\nCBAR,1,1,1,2,0.,1.,0.\nCBAR,2,1,2,5,0.,1.,0.\n", "beam sections with I1"},
      {"PBEAM,1,1,1.-3,1.-6,1.-6,,2.-6\n,\n,1.,1.,,,,,1.-9\nCBEAM,1,1,1,2,0.,1.,0.\nCBEAM,2,1,2,5,0.,1.,0.\n",
       "warping"},
      {"PTUBE,1,1,.1,.01,,.2\nCTUBE,1,1,1,2\nCTUBE,2,1,2,5\n", "taper of PTUBE"},
      {shell + "GRID,9,,.5\nCQUAD8,1,1,1,2,3,4,9\nCQUAD8,2,1,1,2,3,4,9\n", "shells with some of their midside nodes"},
  };
  for (const auto& [cards, what] : changes) {
    const auto deck = nastran(square + cards);
    const auto* note = note_of(deck, what);
    ASSERT_NE(note, nullptr) << what;
    EXPECT_EQ(note->kind, DeckNoteKind::changed) << what;
    EXPECT_EQ(note->count, 2u) << what;
  }
}

TEST(NastranNotes, TellOfTheRulesOfSolids) {
  const std::string solid = square +
                            "GRID,11,,,,1.\nGRID,12,,1.,,1.\nGRID,13,,1.,1.,1.\nGRID,14,,,1.,1.\n"
                            "CHEXA,1,1,1,2,3,4,11,12,+\n+,13,14\n";
  EXPECT_EQ(note_of(nastran(solid + "PSOLID,1,1\n"), "IN of"), nullptr);
  const auto deck = nastran(solid + "PSOLID,1,1,,TWO,GRID,FULL,SMECH\n");
  ASSERT_NE(note_of(deck, "IN of PSOLID"), nullptr);
  EXPECT_EQ(note_of(deck, "ISOP of PSOLID")->kind, DeckNoteKind::doubtful);
  EXPECT_EQ(note_of(deck, "STRESS of PSOLID")->kind, DeckNoteKind::unused);
}

TEST(NastranNumbers, AreSharedByDifferentKindsOfCards) {
  const std::string bars = square + "PBAR,1,1,1.-3,1.-6,1.-6,2.-6\nCBAR,7,1,1,2,0.,1.,0.\n";
  const auto shared = nastran(bars + "CONM2,7,2,,3.\nRBE2,7,2,123,5\n");
  EXPECT_EQ(shared.model.masses.size() + shared.model.links.size(), 2u);
  for (const std::string twice : {"CROD,7,1,1,2\n", "CELAS2,7,5.,1,1\n", "CONM2,8,2,,3.\nCONM2,8,1,,3.\n",
                                  "CONM2,8,2,,3.\nCMASS2,8,1.,1,1\n", "RBE2,8,2,123,5\nRBE2,8,1,123,6\n"})
    EXPECT_NE(nastran_problem(bars + twice).find("is defined twice"), std::string::npos) << twice;
}

TEST(NastranNumbers, OfPropertiesAreSharedByDifferentElements) {
  const std::string both =
      square + "GRID,11,,,,1.\nGRID,12,,1.,,1.\nGRID,13,,1.,1.,1.\nGRID,14,,,1.,1.\n" +
      "CHEXA,3,1,1,2,3,4,11,12,+\n+,13,14\nPSOLID,1,1\n" + quads + shell +
      "PBAR,1,1,1.-3,1.-6,1.-6,2.-6\nCBAR,7,1,1,2,0.,1.,0.\nPROD,1,1,1.-3\nCROD,8,1,1,2\n"
      "PTUBE,1,1,.1,.01\nCTUBE,9,1,1,2\nPBUSH,1,K,5.\nCBUSH,10,1,1,2\nPVISC,1,3.\nCVISC,11,1,1,2\n";
  EXPECT_EQ(nastran(both).model.properties.size(), 5u);
  for (const std::string twice : {"PSHELL,1,1,.02\n", "PCOMP,1\n,1,.01,0.\n", "PBARL,1,1,,ROD\n,.1\n", "PSOLID,1,1\n"})
    EXPECT_NE(nastran_problem(both + twice).find("is defined twice"), std::string::npos) << twice;
  EXPECT_NE(nastran_problem(square + shell + "CBAR,7,1,1,2,0.,1.,0.\n").find("has a PSHELL as its property"),
            std::string::npos);
}

/// Supports of turned points by PS and SPC together hold each motion once.
TEST(NastranSupports, ByPsAndSpcTogetherHoldOnce) {
  const std::string systems =
      "PARAM,COUPMASS,1\nCORD2C,100,,0.,0.,0.,0.,0.,1.\n+,1.,0.,0.\n" + aluminium + "PBAR,1,1,1.-3,1.-6,2.-6,2.-6\n";
  const std::string bar = "GRID,3,100,1.,40.,0.,100\nCBAR,1,1,2,3,0.,0.,1.\n";
  const auto reference =
      test::frequencies(nastran(systems + bar + "GRID,2,100,1.,7.,.2,100\nSPC1,5,123456,2\n").model, 4);
  for (const auto& [ps, spc] : {std::pair{"2", "SPC1,5,123456,2\n"},
                                {"246", "SPC1,5,123456,2\n"},
                                {"123456", "SPC1,5,2,2\n"},
                                {"12", "SPC1,5,3456,2\n"},
                                {"135", "SPC1,5,2346,2\nSPC1,5,15,2\n"}}) {
    const auto deck = nastran(systems + bar + "GRID,2,100,1.,7.,.2,100," + ps + "\n" + spc);
    EXPECT_NEAR((test::frequencies(deck.model, 4) - reference).norm(), 0.0, 1e-9 * reference.norm()) << ps << spc;
  }
}

TEST(NastranMass, OfNsmIsMissingOnlyWhereItIsChosen) {
  const std::string bulk = square + quads + shell + "SPC1,1,123456,1\nNSM1,3,PSHELL,NSM,1.,1\nENDDATA\n";
  const auto kind = [&](const std::string& control) { return note_of(nastran(control + bulk), "NSM1")->kind; };
  EXPECT_EQ(kind("SOL 103\nCEND\nSPC = 1\nBEGIN BULK\n"), DeckNoteKind::unused);
  EXPECT_EQ(kind("SOL 103\nCEND\nSPC = 1\nNSM = 3\nBEGIN BULK\n"), DeckNoteKind::missing);
  EXPECT_EQ(kind(""), DeckNoteKind::missing);
}

/// Statics need no density.
TEST(NastranMass, IsNotNeededByShellsOfAnyKind) {
  const std::string light =
      "GRID,1\nGRID,2,,1.\nGRID,3,,1.,1.\nGRID,4,,,1.\nCQUAD4,1,1,1,2,3,4\nMAT1,1,7.E10,,.3\n"
      "MAT8,8,1.3E11,9.E9,.3,5.E9\nSPC1,1,123456,1,4\n";
  for (const std::string property :
       {"PCOMP,1\n,8,.001,0.,,8,.001,90.\n", "PSHELL,1,1,.01\n", "PSHELL,1,8,.01,8,,8\n"}) {
    const auto deck = nastran(light + property);
    EXPECT_GT(assemble(deck.model).size(), 0) << property;
  }
}

TEST(NastranMatrices, AreRefusedWhereTheyAreNotClear) {
  const std::string bulk = "SOL 103\nCEND\nK2GG = KX\nBEGIN BULK\nGRID,1\nGRID,2\nCONM2,1,1,,1.\nCONM2,2,2,,1.\n";
  const auto with = [&](const std::string& dmig) { return bulk + dmig + "ENDDATA\n"; };
  EXPECT_EQ(nastran_problem(with("DMIG,KX,0,6,1,0\nDMIG,KX,1,1,,1,1,5.\n")), "");
  EXPECT_NE(nastran_problem(with("DMIG,KX,0,6,1,0\nDMIG,KX,1,1,,1,1,5.,2.\n")).find("imaginary"), std::string::npos);
  EXPECT_NE(nastran_problem(with("DMIG,KX,0,6,1,0\nDMIG,KX,0,1,1,0\nDMIG,KX,1,1,,1,1,5.\n")).find("two headers"),
            std::string::npos);
  EXPECT_NE(nastran_problem(with("DMIG,KX,0,6,1,0\nDMIG,KX,1,1,,,,5.\n")).find("whole number"), std::string::npos);
  EXPECT_NE(nastran_problem(with("DMIG,KX,1,1,,1,1,5.\n")).find("has no header"), std::string::npos);
  // PARAM CK2 scales K2GG.
  const auto scaled = nastran(with("PARAM,CK2,3.\nDMIG,KX,0,6,1,0\nDMIG,KX,1,1,,1,1,5.\n"));
  EXPECT_EQ(scaled.model.matrices.at(0).stiffness.coeff(0, 0), 15.0);
  EXPECT_NE(nastran_problem(with("PARAM,CK1,3.\nDMIG,KX,0,6,1,0\nDMIG,KX,1,1,,1,1,5.\n")).find("CK1"),
            std::string::npos);
}

/// A box with a wall of next to nothing twists as the open section that is left.
TEST(NastranSections, OfBoxesThatAreNearlyOpen) {
  const auto torsion = [](double wall) {
    char text[64];
    std::snprintf(text, sizeof text, "+,40.,50.,%.6E,2.5,2.5,2.5\n", wall);
    const auto deck = nastran(
        "GRID,1\nGRID,2,,100.\nMAT1,1,2.1E5,,.3,7.8E-9\nCBAR,1,1,1,2,0.,1.,0.\nPBARL,1,1,,BOX1\n" + std::string(text));
    return std::get<BeamProperty>(deck.model.properties.at("pbarl1")).section.torsion;
  };
  const double open = (2.0 * 48.75 + 37.5) * std::pow(2.5, 3) / 3.0;
  EXPECT_NEAR(torsion(1e-9), open, 1e-3 * open);
  EXPECT_GT(torsion(2e-4), 729.0);
  EXPECT_LT(torsion(2e-4), 800.0);
  // Bredt for a closed box: the part of the walls alone is small.
  const double closed = 4.0 * std::pow(37.5 * 47.5, 2) / (2.0 * (37.5 + 47.5) / 2.5);
  EXPECT_NEAR(torsion(2.5), closed, 0.01 * closed);
}

}  // namespace
}  // namespace kalfem
