// SPDX-License-Identifier: Apache-2.0
// Decks that are not whole, or hold what is not read: what is refused, what is told, and what is left alone.
#include <gtest/gtest.h>

#include <algorithm>

#include "formats/nastran_decks.hpp"

namespace kalfem {
namespace {

using test::frequencies;
using test::has_note;
using test::nastran;
using test::nastran_problem;

DeckNoteKind kind_of(const Deck& deck, const std::string& what) {
  const auto note = std::ranges::find(deck.notes, what, &DeckNote::what);
  EXPECT_NE(note, deck.notes.end()) << what;
  return note == deck.notes.end() ? DeckNoteKind::unused : note->kind;
}

const std::string bar = "GRID,1\nGRID,2,,1.,0.,0.\nCBAR,1,1,1,2,0.,0.,1.\nPBAR,1,1,1.-4,1.-9,2.-9,3.-9\n" +
                        test::aluminium + "SPC1,1,123456,1\n";

TEST(NastranCompleteness, StiffnessMassAndConnectionsThatAreNotReadAreMissing) {
  const auto deck = nastran(bar +
                            "CBEND,7,1,1,2,1,2\nCBEND,8,1,1,2,1,2\nCWELD,9,1\nNSM1,3,PBAR,NSM,1.,1\nGENEL,11\n"
                            "CGAP,12,1,1,2\nCXYZ,13,1,1,2\nENDDATA\n");
  for (const char* what : {"CBEND", "CWELD", "NSM1", "GENEL", "CGAP", "CXYZ"})
    EXPECT_EQ(kind_of(deck, what), DeckNoteKind::missing) << what;
  EXPECT_EQ(std::ranges::find(deck.notes, "CBEND", &DeckNote::what)->count, 2u);
}

TEST(NastranCompleteness, LoadsAndOutputAreNoneOfTheModel) {
  const auto deck =
      nastran(bar + "FORCE,1,2,,1.,0.,0.,1.\nCBARAO,1,LE\nEIGRL,1\nPLOTEL,9,1,2\nDESVAR,1,A,1.\nENDDATA\n");
  for (const auto& note : deck.notes) EXPECT_EQ(note.kind, DeckNoteKind::unused) << note.what;
  EXPECT_EQ(kind_of(deck, "FORCE"), DeckNoteKind::unused);
}

TEST(NastranCompleteness, MatricesOfTheCaseControlThatAreNotReadAreMissing) {
  const auto deck = nastran("SOL 103\nCEND\nSPC = 1\nK2PP = KX\nBEGIN BULK\n" + bar + "ENDDATA\n");
  EXPECT_EQ(kind_of(deck, "K2PP"), DeckNoteKind::missing);
}

TEST(NastranCompleteness, WhatIsAcceptedIsAWarningAndTheRestIsRefused) {
  auto deck = nastran(bar + "CBEND,7,1,1,2,1,2\nCWELD,9,1\nENDDATA\n");
  auto notes = deck.notes;
  IssueList issues;
  EXPECT_EQ(accept_missing(notes, {"cbend", "CFAST"}, issues), std::vector<std::string>{"CFAST"});
  ASSERT_EQ(issues.issues().size(), 1u);
  EXPECT_EQ(issues.issues()[0].location.line, 8);
  EXPECT_NE(issues.issues()[0].what.find("CWELD"), std::string::npos);
  EXPECT_NE(issues.issues()[0].fix.find("accept_missing: [CWELD]"), std::string::npos);
  EXPECT_EQ(std::ranges::find(notes, "CBEND", &DeckNote::what)->kind, DeckNoteKind::doubtful);
}

TEST(NastranCompleteness, DeckThatEndsWithoutEnddataIsRefused) {
  const std::string head = "SOL 103\nCEND\nSPC = 1\nBEGIN BULK\n";
  EXPECT_FALSE(has_note(nastran(head + bar + "ENDDATA\n"), "ENDDATA"));
  EXPECT_FALSE(has_note(nastran(head + bar + "ENDDATA"), "ENDDATA"));
  auto notes = nastran(head + bar).notes;
  IssueList issues;
  accept_missing(notes, {}, issues);
  ASSERT_EQ(issues.issues().size(), 1u);
  EXPECT_EQ(to_string(issues.issues()[0]).find("deck.bdf:10: ENDDATA is missing: the deck may be truncated"), 0u)
      << to_string(issues.issues()[0]);
}

TEST(NastranCompleteness, BulkDataAloneMayEndWithoutEnddataWithAWarning) {
  EXPECT_EQ(kind_of(nastran(bar), "bulk data without ENDDATA"), DeckNoteKind::doubtful);
  EXPECT_FALSE(has_note(nastran(bar + "ENDDATA\n"), "ENDDATA"));
}

TEST(NastranCompleteness, IncludedFileWithoutALastLineEndIsTold) {
  const auto read = [](const std::string& included) {
    return parse_nastran("BEGIN BULK\n" + bar + "INCLUDE 'more.bdf'\nENDDATA\n", "deck.bdf",
                         [=](const std::filesystem::path&) { return included; });
  };
  EXPECT_TRUE(read("CONM2,9,2,,1.5\n").notes.empty());
  const auto cut = read("CONM2,9,2,,1.");
  ASSERT_EQ(cut.notes.size(), 1u);
  EXPECT_EQ(cut.notes[0].kind, DeckNoteKind::doubtful);
  EXPECT_EQ(cut.notes[0].where.file, "more.bdf");
}

/// A ring of nodes about node 1, which leads them by one RBE2 or by two that share nodes 3 and 4.
std::string spider(const std::string& links) {
  return "GRID,1\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nGRID,4,,-1.,0.,0.\nGRID,5,,0.,-1.,0.\nCONM2,2,2,,1.\n"
         "CONM2,3,3,,2.\nCONM2,4,4,,3.\nCONM2,5,5,,4.\nCELAS2,21,100.,1,1\nCELAS2,22,200.,1,2\nCELAS2,23,300.,1,3\n"
         "CELAS2,24,10.,1,4\nCELAS2,25,20.,1,5\nCELAS2,26,30.,1,6\n" +
         links + "ENDDATA\n";
}

TEST(NastranRigidElements, OfOneMasterThatShareNodesAreOneBody) {
  const auto one = nastran(spider("RBE2,9,1,123456,2,3,4,5\n"));
  const auto shared = nastran(spider("RBE2,9,1,123456,2,3,4\nRBE2,10,1,123,3,4,5\nRBE2,11,1,456,5\n"));
  EXPECT_TRUE(has_note(shared, "RBE2s of one master that share nodes"));
  EXPECT_FALSE(has_note(one, "RBE2s"));
  const auto expected = frequencies(one.model, 6);
  EXPECT_LT((frequencies(shared.model, 6) - expected).norm(), 1e-12 * expected.norm());  // rounding
}

TEST(NastranRigidElements, OfTwoMastersThatShareANodeAreRefusedWithTheirLines) {
  const auto problem = nastran_problem(spider("RBE2,9,1,123456,2,3\nRBE2,10,5,123456,3,4\n"));
  EXPECT_NE(problem.find("grid point 3 follows from RBE2 10 and from RBE2 9 in line 16"), std::string::npos) << problem;
  EXPECT_NE(problem.find("deck.bdf:17"), std::string::npos) << problem;
}

TEST(NastranRigidElements, ThatClashWithOtherLinksAreRefusedWithTheirLines) {
  const auto deck = nastran(spider("RBE2,9,1,123456,2,3,4\nRBE3,10,,2,123,1.,123,3,4\n,5\n"));
  try {
    assemble(deck.model);
    ADD_FAILURE() << "node 2 follows twice";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("'rbe2_9' (line 16) and from 'rbe3_10' (line 17)"), std::string::npos)
        << error.what();
  }
}

/// A cantilever strip of 1 m x 0.05 m in a plane turned by `tilt` about x, with what holds further rotations.
std::string strip(double tilt, const std::string& held) {
  std::string deck;
  const auto place = [&](double x, double y) {
    return std::to_string(x) + "," + std::to_string(y * std::cos(tilt)) + "," + std::to_string(y * std::sin(tilt));
  };
  for (int i = 0; i <= 20; ++i)
    for (int j = 0; j <= 2; ++j)
      deck += "GRID," + std::to_string(1 + 3 * i + j) + ",," + place(0.05 * i, 0.025 * j) + "\n";
  for (int i = 0; i < 20; ++i)
    for (int j = 0; j < 2; ++j) {
      const int n = 1 + 3 * i + j;
      deck += "CQUAD4," + std::to_string(2 * i + j + 1) + ",1," + std::to_string(n) + "," + std::to_string(n + 3) +
              "," + std::to_string(n + 4) + "," + std::to_string(n + 1) + "\n";
    }
  return deck + "PSHELL,1,1,.002,1,,1\nMAT1,1,2.1E11,,.3,7850.\nSPC1,1,123456,1,2,3\n" + held + "ENDDATA\n";
}

/// Held everywhere, the turn about the normal must leave the bending of the strip in its plane as it is: 41.8 Hz by
/// Euler and Bernoulli, 1.8751^2 / (2 pi L^2) b sqrt(E / (12 rho)), within 2 % on this mesh.
TEST(NastranHeldDrilling, LeavesTheMembraneAsItIs) {
  const auto free = frequencies(nastran(strip(0.0, "")).model, 6);
  const double in_plane = 41.8;
  const auto has = [&](const Eigen::VectorXd& found) {
    return (found.array() - in_plane).abs().minCoeff() < 0.02 * in_plane;
  };
  ASSERT_TRUE(has(free)) << free.transpose();
  for (const std::string held : {"GRDSET,,,,,,,6\n", "SPC1,1,6,1,THRU,63\n"}) {
    const auto deck = nastran(strip(0.0, held));
    EXPECT_LT((frequencies(deck.model, 6) - free).norm(), 1e-12 * free.norm()) << held;  // rounding
    EXPECT_TRUE(has_note(deck, "at 60 nodes these rotations are left free")) << held;
  }
}

/// In a tilted plane the direction that is held has a part of bending, which the free turn about the normal takes up:
/// without the stiffness of K6ROT at no cost.
TEST(NastranHeldDrilling, LeavesATiltedMembraneAsItIs) {
  const auto free = frequencies(nastran(strip(0.3, "")).model, 6);
  const auto held = frequencies(nastran(strip(0.3, "GRDSET,,,,,,,6\nPARAM,K6ROT,0.\n")).model, 6);
  // found 5e-11: roundings of a thin strip, by its condition
  EXPECT_LT((held - free).norm(), 5e-10 * free.norm()) << held.transpose() << "\n" << free.transpose();
}

/// Rotations that bend the strip stay held.
TEST(NastranHeldDrilling, KeepsOtherRotationsHeld) {
  const auto free = frequencies(nastran(strip(0.0, "")).model, 1);
  const auto held = frequencies(nastran(strip(0.0, "SPC1,1,56,1,THRU,63\n")).model, 1);
  EXPECT_GT(held[0], 3.0 * free[0]);
}

}  // namespace
}  // namespace kalfem
