// SPDX-License-Identifier: Apache-2.0
// Abaqus and CalculiX decks that are not whole, or hold what is not read.
#include <gtest/gtest.h>

#include "formats/abaqus_decks.hpp"

namespace kalfem {
namespace {

const std::string truss = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=T3D2, ELSET=E\n1, 1, 2\n" + deck_steel +
                          "*SOLID SECTION, ELSET=E, MATERIAL=steel\n1e-4\n";

std::string problem_of(const std::string& text) {
  try {
    parse_deck(text);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

const DeckNote* find_note(const Deck& deck, const std::string& what) {
  const auto note = std::ranges::find(deck.notes, what, &DeckNote::what);
  return note == deck.notes.end() ? nullptr : &*note;
}

TEST(AbaqusCompleteness, ContactAndUnknownKeywordsAreMissing) {
  const auto deck = parse_deck(truss + "*CONTACT PAIR, INTERACTION=I\nA, B\n*BOUNDRY\n1, 1, 3\n*FRICTION\n0.1\n");
  ASSERT_TRUE(find_note(deck, "*CONTACT PAIR") && find_note(deck, "*BOUNDRY") && find_note(deck, "*FRICTION"));
  EXPECT_EQ(find_note(deck, "*CONTACT PAIR")->kind, DeckNoteKind::missing);
  EXPECT_EQ(find_note(deck, "*BOUNDRY")->kind, DeckNoteKind::missing);
  EXPECT_EQ(find_note(deck, "*FRICTION")->kind, DeckNoteKind::unused);
  auto notes = deck.notes;
  IssueList issues;
  EXPECT_TRUE(accept_missing(notes, {"contact pair", "*BOUNDRY"}, issues).empty());
  EXPECT_TRUE(issues.empty());
}

TEST(AbaqusCompleteness, DeckThatEndsInsideADataLineIsRefused) {
  EXPECT_EQ(problem_of(truss + "*BOUNDARY\n1, 1, 3\n"), "");
  EXPECT_EQ(problem_of(truss + "*BOUNDARY\n1, 1, 3\n*STEP\n*FREQUENCY\n1\n*END STEP"), "");
  EXPECT_EQ(problem_of(truss + "*BOUNDARY\n1, 1, 3\n** end"), "");
  const auto problem = problem_of(truss + "*BOUNDARY\n1, 1, 3\n2, 2");
  EXPECT_NE(problem.find("has no line end"), std::string::npos) << problem;
  EXPECT_NE(problem.find("deck.inp:15"), std::string::npos) << problem;
}

TEST(AbaqusCompleteness, SignsOfNumbersStandAlone) {
  for (const char* number : {"+-1.", "-+1.", "1.e+-2", "1.+-2", "++1."})
    EXPECT_NE(problem_of(truss + "*NODE\n3, " + number + ", 0., 0.\n").find("is not a number"), std::string::npos)
        << number;
  for (const char* number : {"+1.", "-1.", "1.e+2", "1.-2", "+1.D-2"})
    EXPECT_EQ(problem_of(truss + "*NODE\n3, " + number + ", 0., 0.\n"), "") << number;
  EXPECT_NE(problem_of(truss + "*NODE\n+-3, 1., 0., 0.\n"), "");
}

/// A strip of shells that bends in its plane: the turn about the normal is held at every node, or free.
std::string strip(const std::string& held) {
  std::string deck = "*NODE, NSET=ALL\n";
  for (int i = 0; i <= 10; ++i)
    for (int j = 0; j <= 1; ++j)
      deck +=
          std::to_string(1 + 2 * i + j) + ", " + std::to_string(0.1 * i) + ", " + std::to_string(0.05 * j) + ", 0.\n";
  deck += "*ELEMENT, TYPE=S4, ELSET=E\n";
  for (int i = 0; i < 10; ++i) {
    const int n = 1 + 2 * i;
    deck += std::to_string(i + 1) + ", " + std::to_string(n) + ", " + std::to_string(n + 2) + ", " +
            std::to_string(n + 3) + ", " + std::to_string(n + 1) + "\n";
  }
  return deck + deck_steel + "*SHELL SECTION, ELSET=E, MATERIAL=steel\n.002\n*BOUNDARY\n1, 1, 6\n2, 1, 6\n" + held;
}

/// CalculiX 2.20 gives the same frequencies with and without the line "ALL, 6, 6".
TEST(AbaqusHeldDrilling, LeavesTheMembraneAsItIs) {
  const auto free = Matrices(parse_deck(strip("")).model).frequencies(6);
  const auto deck = parse_deck(strip("ALL, 6, 6\n"));
  EXPECT_LT((Matrices(deck.model).frequencies(6) - free).norm(), 1e-12 * free.norm());  // rounding
  EXPECT_TRUE(find_note(deck, "fixed rotations of shells about their normal"));
}

}  // namespace
}  // namespace kalfem
