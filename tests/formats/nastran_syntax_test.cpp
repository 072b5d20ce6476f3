// SPDX-License-Identifier: Apache-2.0
// How cards are written: images, continuation markers, tenth fields, free text, names of included files.
#include <gtest/gtest.h>

#include "formats/nastran_decks.hpp"

namespace kalfem {
namespace {

using test::nastran;
using test::nastran_problem;

const std::string mass = "CONM2,900,1,,1.\nCELAS2,901,5.,1,1\n";

Eigen::Vector3d place_of(const Deck& deck, std::int64_t id) {
  const auto& ids = deck.model.mesh.node_ids;
  const auto found = std::ranges::find(ids, id);
  EXPECT_NE(found, ids.end()) << id;
  return deck.model.mesh.nodes.col(found - ids.begin());
}

TEST(NastranImages, RepeatTheCardBefore) {
  const auto deck = nastran("GRID,1\nGRID,101,,1.0,10.5,,,3456\n=,*(1),=,*(0.2),==\n=(3)\n" + mass);
  EXPECT_EQ(deck.model.mesh.node_count(), 6);
  // rounding of sums
  EXPECT_NEAR((place_of(deck, 102) - Eigen::Vector3d(1.2, 10.5, 0.0)).norm(), 0.0, 1e-14);
  EXPECT_NEAR((place_of(deck, 105) - Eigen::Vector3d(1.8, 10.5, 0.0)).norm(), 0.0, 1e-14);
  EXPECT_EQ(deck.model.mesh.node_sets.at("grid_ps").size(), 5u);
}

TEST(NastranImages, StandInEveryField) {
  for (const std::string images :
       {"=,*1,=,*1.,==\n=(2)\n", "=       *(1)    =       *(1.)   ==\n=(2)\n", "=(3),*(1),=,*(1.),==\n",
        "=,*(1),,*(1.)\n=,*(1),,*(1.)\n=,*(1),,*(1.)\n", "=,*(1),=,*(1.),==\n=2\n"}) {
    const auto deck = nastran("GRID,1,,0.,0.,0.\n" + images + mass);
    EXPECT_EQ(deck.model.mesh.node_count(), 4) << images;
    EXPECT_EQ(place_of(deck, 4), Eigen::Vector3d(3.0, 0.0, 0.0)) << images;
  }
  // Elements too, whose numbers are whole.
  const auto rods = nastran(
      "GRID,1\n=,*(1),=,*(1.)\n=(3)\nMAT1,1,7.E10,,.3,2700.\nPROD,1,1,1.-3\nCROD,1,1,1,2\n"
      "=,*(1),=,*(1),*(1)\n=(2)\n");
  EXPECT_EQ(rods.model.mesh.regions.at("prod1").size(), 4u);
}

TEST(NastranImages, AreToldWhereTheyAreNone) {
  for (const std::string text :
       {"=,*(1)\nGRID,1\n", "GRID,1\n=(3)\n", "GRID,1\n=(x),*(1)\n", "GRID,1\n=(900000000),*(1)\n",
        "GRID,1\nSPC1,1,123,1,2,3,4,5,6,+\n+,7,8\n=,*(1)\n", "GRID,1,,ABC\n=,*(1),,*(1)\n"})
    EXPECT_NE(nastran_problem(text).find("replicated"), std::string::npos) << text;
}

TEST(NastranMarkers, DifferInCaseAndFirstCharacter) {
  const std::string nodes = "GRID,1\nGRID,2\n" + mass;
  for (const std::string conm2 :
       {"CONM2   12      2               2.                                      +B2\n"
        "+b2     .2              .2                      .2\n",
        "CONM2   12      2               2.                                       B2\n"
        "+B2     .2              .2                      .2\n",
        "CONM2   12      2               2.                                      *B2\n"
        "+B2     .2              .2                      .2\n",
        "CONM2,12,2,,2.,,,,,B2\n+B2,.2,,.2,,,.2\n", "CONM2,12,2,,2.,,,,,+b2\n+B2,.2,,.2,,,.2\n",
        "CONM2   12      2               2.                                             7\n"
        "+       .2              .2                      .2\n",
        // elsewhere
        "CONM2   12      2               2.                                       b2\n"
        "GRID    3\n"
        "+B2     .2              .2                      .2\n"}) {
    const auto deck = nastran(nodes + conm2);
    const auto heavy = std::ranges::find(deck.model.masses, "conm2_12", &PointMass::name);
    ASSERT_NE(heavy, deck.model.masses.end()) << conm2;
    EXPECT_EQ(heavy->inertia(2, 2), 0.2) << conm2;
  }
}

TEST(NastranMarkers, HaveCommasBehindThem) {
  std::string nodes = mass;
  for (int i = 1; i <= 11; ++i) nodes += "GRID," + std::to_string(i) + "\n";
  for (const std::string spc :
       {"SPC1,5,123,1,2,3,4,5,6,+,\n+,7,8,9,10,11,\n", "SPC1,5,123,1,2,3,4,5,6,+A,,,\n+A,7,8,9,10,11\n",
        "SPC1,5,123,1,2,3,4,5,6,A\n+A,7,8,9,10,11\n", "SPC1,5,123,1,2,3,4,5,6,,\n,7,8,9,10,11,,,,,,\n"})
    EXPECT_EQ(nastran(nodes + spc).model.mesh.node_sets.at("spc5").size(), 11u) << spc;
}

TEST(NastranMarkers, AreNotEveryTenthField) {
  for (const std::string grid : {"GRID,1,,2.,,,,,,NOTE\n", "GRID,1,,2.,,,,,,17\n", "GRID,1,,2.,,,,,,NOTE,,\n",
                                 "GRID    1               2.                                              NOTE0001\n"})
    EXPECT_EQ(place_of(nastran(grid + mass), 1), Eigen::Vector3d(2.0, 0.0, 0.0)) << grid;
  EXPECT_NE(nastran_problem("GRID,1\nSPC1,1,123,4,5,6,7,8,9,10\n").find("tenth field"), std::string::npos);
}

TEST(NastranFreeText, IsPassedOver) {
  for (const std::string text :
       {"DEQATN  5       F(RTIP,RROOT) = RTIP - RROOT\n", "DEQATN  5       F(A,B)=A+\n        = B**2, C\n+       -1.\n",
        "DEQATN,5,F(A,B)=A-B\n", "DEQATN  5       F1(A,B,C) = A + B;      +\n+       F2 = SQRT(F1)\n",
        "MONPNT1 WING    Bending, at the root of the wing\n        WING    123     5       0.      0.      0.\n"}) {
    const auto deck = nastran("GRID,1\n" + text + mass + "ENDDATA\n");
    EXPECT_EQ(deck.model.masses.size(), 1u) << text;
    for (const auto& note : deck.notes) EXPECT_EQ(note.kind, DeckNoteKind::unused) << note.what;
  }
}

TEST(NastranComponents, MayHoldBlanks) {
  const std::string nodes = "GRID,1\nGRID,2\n" + mass + "CONM2,2,2,,1.,,,,,+\n+,1.,,1.,,,1.\n";
  const auto blanks = nastran(nodes + "SPC1    5       12 456  2\nRBE2    7       1       1 2     2\n");
  const auto& held = blanks.model.fixed.at(0).directions;
  EXPECT_EQ(held, (std::array<bool, 6>{true, true, false, true, true, true}));
  EXPECT_EQ(blanks.model.links.at(0).tied, (std::array<bool, 6>{true, true, false, false, false, false}));
}

TEST(NastranIncludes, AreFoundBesideTheFirstFileToo) {
  const std::map<std::string, std::string> files = {{"run/sub/all.bdf", "GRID,1\nINCLUDE 'sub/masses.bdf'\n"},
                                                    {"run/sub/masses.bdf", mass},
                                                    {"run/sub/lost.bdf", "INCLUDE 'gone.bdf'\n"}};
  const NastranIncludes load = [&](const std::filesystem::path& path) {
    const auto file = files.find(path.generic_string());
    if (file == files.end()) throw InvalidInput("no such file", "", "");
    return file->second;
  };
  EXPECT_EQ(parse_nastran("INCLUDE 'sub/all.bdf'\n", "run/main.dat", load).model.masses.size(), 1u);
  try {
    parse_nastran("INCLUDE 'sub/lost.bdf'\n", "run/main.dat", load);
    FAIL();
  } catch (const InvalidInput& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("INCLUDE 'gone.bdf'"), std::string::npos) << message;
    EXPECT_NE(message.find("run/sub/gone.bdf"), std::string::npos) << message;
    EXPECT_NE(message.find("'run/gone.bdf'"), std::string::npos) << message;
  }
}

}  // namespace
}  // namespace kalfem
