// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "kalfem/formats/abaqus.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

std::map<std::string, std::string> files;  ///< what *INCLUDE finds

Deck parse(const std::string& text) {
  return parse_abaqus(text, "folder/deck.inp", [](const std::filesystem::path& path) {
    const auto file = files.find(path.generic_string());
    if (file == files.end()) throw InvalidInput(Issue{{path.string(), 0}, "no such file", "it does not exist", ""});
    return file->second;
  });
}

/// The problems that a deck is refused with.
std::vector<Issue> problems_of(const std::string& text) {
  try {
    parse(text);
  } catch (const InvalidInput& error) {
    return error.issues();
  }
  ADD_FAILURE() << "the deck was read";
  return {};
}

void expect_problem(const std::string& text, int line, const std::string& part) {
  const auto issues = problems_of(text);
  for (const auto& issue : issues)
    if (issue.location.line == line && to_string(issue).find(part) != std::string::npos) return;
  ADD_FAILURE() << "no problem in line " << line << " with '" << part
                << "', but: " << (issues.empty() ? "none" : InvalidInput(issues).what());
}

const std::string nodes = "*NODE, NSET=All\n1, 0, 0, 0\n2, 1, 0, 0\n3, 1, 1, 0\n4, 0, 1, 0\n";  // lines 1 to 5
const std::string plate = nodes + "*ELEMENT, TYPE=S4, ELSET=Plate\n1, 1, 2, 3, 4\n";            // lines 6, 7
const std::string properties =
    "*MATERIAL, NAME=al\n*ELASTIC\n7e10, 0.3\n*DENSITY\n2700\n*SHELL SECTION, ELSET=Plate, MATERIAL=al\n0.01\n";

TEST(AbaqusSyntax, KeywordsInAnyCaseWithCommentsContinuationsAndLineEnds) {
  const auto deck = parse(
      "** comment\r\n*heading\r\nsome, text\r\n*Node ,nset = My Nodes\r\n 1, +0., 1.5D0, -2.E-1,\r\n** between\r\n\r\n"
      "2,1.,,\r\n3, 1.,1.\r\n4,,1.\r\n*ELEMENT,\r\nTYPE=s4 , elset=\"the plate\"\r\n1, 1, 2,\r\n 3, 4\r\n"
      "*material,name=AL\r\n*elastic\r\n7E10,.3,\r\n*density\r\n2700.,\r\n"
      "*shell section, material=al, elset=\"The Plate\"\r\n0.01,5\r\n");
  const auto& mesh = deck.model.mesh;
  ASSERT_EQ(mesh.node_count(), 4);
  EXPECT_TRUE(mesh.nodes.col(0).isApprox(Eigen::Vector3d(0.0, 1.5, -0.2)));
  EXPECT_EQ(mesh.node_sets.at("My Nodes").size(), 4u);
  ASSERT_EQ(mesh.regions.count("the plate"), 1u);
  EXPECT_EQ(std::get<ShellProperty>(deck.model.properties.at("the plate")).material, "AL");
  for (const auto& note : deck.notes) EXPECT_EQ(note.kind, DeckNoteKind::unused) << note.what;
}

TEST(AbaqusSyntax, SetsByNumbersRangesAndNames) {
  const auto deck =
      parse(plate + properties +
            "*NSET, NSET=odd, GENERATE\n1, 99, 2\n*NSET, NSET=mixed\nodd, 2,\n3\n*NSET, NSET=of, ELSET=Plate\n");
  const auto& sets = deck.model.mesh.node_sets;
  EXPECT_EQ(sets.at("odd"), (std::vector<Index>{0, 2}));
  EXPECT_EQ(std::set<Index>(sets.at("mixed").begin(), sets.at("mixed").end()), (std::set<Index>{0, 1, 2}));
  EXPECT_EQ(sets.at("of").size(), 4u);
}

TEST(AbaqusSyntax, IncludedFilesStandInTheirPlace) {
  files = {{"folder/parts/mesh.inp", "1, 0, 0, 0\n2, 1, 0, 0\n*INCLUDE, INPUT=more.inp\n"},
           {"folder/parts/more.inp", "3, 1, 1, 0\n4, 0, 1, 0\n"},
           {"folder/elements.txt", "1, 1, 2, 3, 4\n"}};
  const auto deck =
      parse("*NODE\n*include, input=parts/mesh.inp\n*ELEMENT, TYPE=S4, ELSET=Plate, INPUT=elements.txt\n" + properties);
  EXPECT_EQ(deck.model.mesh.node_count(), 4);
  EXPECT_EQ(deck.model.mesh.cells.size(), 1u);
}

TEST(AbaqusSyntax, MissingAndRingIncludesAreTold) {
  files = {{"folder/a.inp", "*INCLUDE, INPUT=b.inp\n"}, {"folder/b.inp", "**\n*INCLUDE, INPUT=a.inp\n"}};
  expect_problem("*INCLUDE, INPUT=a.inp\n", 2, "includes itself");
  expect_problem("**\n*INCLUDE, INPUT=none.inp\n", 2, "none.inp");
}

TEST(AbaqusSyntax, ProblemsOfTheMeshAreToldTogetherWithTheirLines) {
  const std::string text =
      nodes + "2, 5, 0, 0\n5, x, 0, 0\n*ELEMENT, TYPE=S4, ELSET=Plate\n1, 1, 2, 3, 77\n1, 4, 3, 2, 1\n2, 1, 2, 3\n";
  expect_problem(text, 6, "defined again");
  expect_problem(text, 7, "'x'");
  expect_problem(text, 10, "defined twice");
  expect_problem(text, 11, "3 nodes");
  expect_problem(nodes + "*ELEMENT, TYPE=S4, ELSET=Plate\n1, 1, 2, 3, 77\n" + properties, 7, "unknown node 77");
}

TEST(AbaqusSyntax, AFewProblemsAreListed) {
  std::string text = "*NODE\n";
  for (int i = 0; i < 100; ++i) text += "x\n";
  EXPECT_EQ(problems_of(text).size(), 13u);
}

TEST(AbaqusSyntax, MissingSectionsMaterialsAndEnds) {
  expect_problem(plate, 7, "no section");
  expect_problem(plate + "*SHELL SECTION, ELSET=Plate, MATERIAL=none\n0.01\n", 8, "no material 'none'");
  expect_problem(plate + "*SHELL SECTION, ELSET=Plat, MATERIAL=none\n0.01\n", 8, "did you mean 'Plate'");
  expect_problem("*PART, NAME=p\n" + plate, 1, "not closed");
  expect_problem(plate + properties + "*STEP\n*STATIC\n", 15, "not closed");
  expect_problem("no deck at all\n", 1, "begins with");
  expect_problem("", 1, "no nodes");
}

TEST(AbaqusSyntax, WhatWouldLeaveTheModelIncompleteIsRefused) {
  expect_problem(plate + properties + "*NGEN\n1, 4\n", 15, "*NGEN");
  expect_problem(plate + "*ELEMENT, TYPE=CPS4\n9, 1, 2, 3, 4\n" + properties, 8, "CPS4");
  expect_problem(plate + properties + "*EMBEDDED ELEMENT\n1\n", 15, "joining");
}

TEST(AbaqusSyntax, WhatHasNoEffectIsNotedOncePerKeyword) {
  const auto deck = parse(plate + properties +
                          "*CONTACT PAIR, INTERACTION=i\na, b\n*WHATEVER\n"
                          "*STEP\n*STATIC\n*CLOAD\n1, 3, 5.\n*CLOAD\n2, 3, 5.\n*NODE FILE\nU\n*END STEP\n");
  std::map<std::string, DeckNote> notes;
  for (const auto& note : deck.notes) notes.emplace(note.what, note);
  ASSERT_TRUE(notes.contains("*CLOAD"));
  EXPECT_EQ(notes.at("*CLOAD").count, 2u);
  EXPECT_EQ(notes.at("*CLOAD").where.line, 20);
  EXPECT_EQ(notes.at("*CONTACT PAIR").consequence, "contact does not join the parts");
  EXPECT_NE(notes.at("*WHATEVER").consequence.find("unknown keyword"), std::string::npos);
}

TEST(AbaqusSyntax, SetsInARingAndUnreadableLinesAreTold) {
  expect_problem(plate + properties + "*NSET, NSET=a\nb\n*NSET, NSET=b\na\n", 18, "contains itself");
  expect_problem(plate + properties + "*NSET, NSET=a, GENERATE\n5, 1\n", 16, "not a range");
  expect_problem(plate + properties + "*BOUNDARY\nAll, q\n", 16, "directions");
  expect_problem(plate + properties + "*BOUNDARY\nAl, 1\n", 16, "did you mean 'All'");
  expect_problem(plate + properties + "*EQUATION\n3\n1, 1, 1., 2, 1, -1.\n", 16, "2 of 3 terms");
}

}  // namespace
}  // namespace kalfem
