// SPDX-License-Identifier: Apache-2.0
// How lines become cards and fields become numbers.
#include <gtest/gtest.h>

#include "formats/nastran_decks.hpp"
#include "kalfem/formats/nastran/card.hpp"

namespace kalfem {
namespace {

using nastran::parse_integer;
using nastran::parse_real;
using test::nastran_problem;

TEST(NastranNumbers, AreReadInEveryNotation) {
  const std::vector<std::pair<const char*, double>> cases = {
      {"1.5", 1.5},    {".5", 0.5},        {"-.5", -0.5},    {"7", 7.0},    {"1.2-3", 1.2e-3},         {"1.+5", 1e5},
      {"1D3", 1000.0}, {"7.7E-4", 7.7e-4}, {"2.d+2", 200.0}, {"+3.5", 3.5}, {"-1.032-10", -1.032e-10}, {"1.e5", 1e5},
      {"0.", 0.0},     {"4.2+12", 4.2e12}, {"1.E-400", 0.0}};
  for (const auto& [text, value] : cases) {
    const auto read = parse_real(text);
    ASSERT_TRUE(read) << text;
    EXPECT_DOUBLE_EQ(*read, value) << text;
  }
}

TEST(NastranNumbers, AreRefusedWhereTheyAreNone) {
  for (const char* text :
       {"", "abc", "1.2.3", "1.2e", "--1", "1e400", "1.0E+5+3", "-", ".", "1-2-3", "nan", "inf", "0x1p3", "+-1"})
    EXPECT_FALSE(parse_real(text)) << text;
  EXPECT_EQ(parse_integer("+12"), 12);
  for (const char* text : {"", "1.", "12a", "99999999999999999999", "+-1"}) EXPECT_FALSE(parse_integer(text)) << text;
}

/// One node at (1.5, 0, -2.5) beside the fixed one, however it is written.
void expect_node(const std::string& grid) {
  const auto deck = test::nastran("GRID,7\n" + grid + "\nCONM2,1,8,0,3.\nCELAS2,2,4.,7,1,8,1\n");
  ASSERT_EQ(deck.model.mesh.node_ids, (std::vector<std::int64_t>{7, 8})) << grid;
  EXPECT_EQ(deck.model.mesh.nodes.col(1), Eigen::Vector3d(1.5, 0.0, -2.5)) << grid;
}

TEST(NastranCards, AreReadInEveryField) {
  expect_node("GRID    8               1.5             -2.5");
  expect_node("grid    8               1.5             -2.5    $ comment, with commas");
  expect_node(
      "GRID    8               1.5     0.0     -25.-1                                  IGNORED BEYOND COLUMN 80");
  expect_node("GRID*   8                               1.5             0.              \n*       -2.5");
  expect_node("GRID*   8                               1.5             0.              *N1\n*N1     -2.5");
  expect_node("GRID,8,,1.5,,-2.5");
  expect_node("GRID, 8, , 1.5, , -2.5 $ end");
  expect_node("GRID*,8,,1.5,0.\n*,-2.5");
  expect_node("GRID*,8,,1.5,0.,*A\n*A,-2.5");
  expect_node("GRID\t8\t\t1.5\t\t-2.5");
  expect_node("GRID    8               1.5             -2.5\r");
}

TEST(NastranCards, GoOnOverLines) {
  // Eleven nodes of a support, in all manners of continuation.
  std::string nodes;
  for (int i = 1; i <= 11; ++i)
    nodes += "GRID," + std::to_string(i) + "\nCONM2," + std::to_string(i) + "," + std::to_string(i) + ",,1.\n";
  for (const std::string spc :
       {"SPC1    5       123     1       2       3       4       5       6\n        7       8       9       10      11",
        "SPC1    5       123     1       2       3       4       5       6       +\n+       7       8       9       10 "
        "     11",
        "SPC1    5       123     1       2       3       4       5       6       +A\n+A      7       8       9       "
        "10      11",
        "SPC1,5,123,1,2,3,4,5,6\n,7,8,9,10,11", "SPC1,5,123,1,2,3,4,5,6,+\n+,7,8,9,10,11",
        "SPC1,5,123,1,2,3,4,5,6,+X1\n+X1,7,8,9,10,11", "SPC1,5,123,1,2,3,4,5,6,+,7,8,9,10,11",
        "SPC1*   5               123             1               2               \n*       3               4           "
        "    5               6\n        7       8       9       10      11",
        "SPC1    5       123     1       THRU    11", "SPC1    5       123     1       THRU    20",
        "SPC1,5,123,1,THRU,11,EXCEPT,3\nSPC,5,3,123"}) {
    const auto deck = test::nastran(nodes + spc + "\n");
    EXPECT_EQ(deck.model.mesh.node_sets.at("spc5").size(), 11u) << spc;
  }
}

/// Lines without values count as eight (four) blank ones, and a large line alone as eight.
TEST(NastranCards, KeepTheirPlaceOverBlankLines) {
  const std::string head = "MAT1,1,1.,,.3,1.\nGRID,1\nGRID,2,,1.\nCBEAM,1,1,1,2,0.,1.,0.\n";
  for (const std::string pbeam :
       {"PBEAM,1,1,1.,1.,1.,,1.\n,\n,.5,.6\n,,,,,.7,.8\n",
        "PBEAM   1       1       1.      1.      1.              1.\n+\n        .5      .6\n*\n*       .7              "
        ".8\n",
        "PBEAM   1       1       1.      1.      1.              1.\n*\n        .5      .6\n+\t\t\t\t\t.7\t.8\n",
        "PBEAM*,1,1,1.,1.\n*,1.,,1.\n*\n*\n*,.5,.6\n*\n*\n*,.7,.8\n"}) {
    const auto deck = test::nastran(head + pbeam);
    const auto& section = std::get<BeamProperty>(deck.model.properties.at("pbeam1")).section;
    EXPECT_EQ(section.shear_factor_y, 0.5) << pbeam;
    EXPECT_EQ(section.shear_factor_z, 0.6) << pbeam;
    EXPECT_EQ(section.centroid, Eigen::Vector2d(0.7, 0.8)) << pbeam;
  }
}

TEST(NastranCards, FindTheirContinuationsAnywhere) {
  const auto deck = test::nastran(
      "GRID,1\nGRID,2\nGRID,3\nGRID,4\n"
      "CONM2   11      1               1.                                      +B1\n"
      "CONM2   12      2               2.                                      +B2\n"
      "+B2     .2              .2                      .2\n"
      "CONM2   13      3               3.                                      +B3\n"
      "GRID    5\n"
      "+B3     .3              .3                      .3\n"
      "+B1     .1              .1                      .1\n");
  ASSERT_EQ(deck.model.masses.size(), 3u);
  for (const auto& mass : deck.model.masses) {
    EXPECT_DOUBLE_EQ(mass.inertia(0, 0), mass.mass / 10.0) << mass.name;
    EXPECT_DOUBLE_EQ(mass.inertia(2, 2), mass.mass / 10.0) << mass.name;
  }
}

TEST(NastranCards, AreToldWhereTheyCannotBeRead) {
  const auto expect = [](const std::string& text, const std::string& part) {
    const auto message = nastran_problem(text);
    EXPECT_NE(message.find(part), std::string::npos) << text << "\n-> " << message;
  };
  expect("GRID,1,,abc\n=,*1,=,*1.\n", "replicated");
  expect("GRID,1,,abc\n", "deck.bdf:1: GRID 1: X (line 1 of the card, field 4) is 'abc'");
  expect("GRID,x\n", "whole number");
  expect("GRID,1\n+,2\nGRID,1,,5.\n", "defined twice");
  expect("GRID,1\nGRID,1,,,,,,123\n", "defined twice");  // the supports of the second would be lost
  expect("GRID,1\nPVISC,3,10.\nPVISC,3,20.\n", "PVISC 3 is defined twice");
  expect("+,2\nGRID,1\n", "without a card before it");
  expect("GRID,1\nCONM2,1,2,,1.\n", "deck.bdf:2: CONM2 1: grid point 2 is missing");
  expect("GRID,1\nGRID,2\nCROD,1,5,1,2\n", "property 5 is missing");
  expect("GRID,1\nGRID,2\nPROD,5,9,1.\nCROD,1,5,1,2\n", "material 9 is missing");
  expect("GRID,1,7\n", "coordinate system 7 is missing");
  expect("GRID,1\nCONM2,1,1,,1.\nCONM2,1,1,,1.\n", "element 1 is defined twice");
  expect("GRID,1\nGRID,2\nPBCOMP,5,9,1.\nCBEAM,1,5,1,2,0.,0.,1.\n", "PBCOMP 5");
  expect("INCLUDE 'more.bdf'\nGRID,1\n", "INCLUDE 'more.bdf'");
  expect("INCLUDE 'more.bdf\nGRID,1\n", "is not closed");
  expect("SOL 103\nCEND\nSPC = 4\nBEGIN BULK\nGRID,1\nCONM2,1,1,,1.\n", "SPC = 4");
  expect("SPC1,1,123,4,5,6,7,8,9,10\nGRID,1\n", "in its tenth field");
  expect("", "no grid points");
}

TEST(NastranCards, AreToldManyAtOnceButNotEndlessly) {
  std::string text;
  for (int i = 1; i <= 30; ++i) text += "GRID," + std::to_string(i) + ",,x\n";
  try {
    test::nastran(text);
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_EQ(error.issues().size(), 13u);
    EXPECT_NE(std::string(error.what()).find("and 18 more problems"), std::string::npos);
  }
}

TEST(NastranCards, ThatAreNotUsedAreNoted) {
  const auto deck = test::nastran(
      "GRID,1\nGRID,2\nCONM2,1,1,,1.\nCELAS2,2,1.,1,1\nFORCE,1,1,0,1.,1.,0.,0.\nFORCE,1,1,0,1.,1.,0.,0.\nEIGRL,1,,,10\n"
      "CBEND,3,1,1,2,1,2\nZZTOP,1\nCWHAT,9\n");
  EXPECT_TRUE(test::has_note(deck, "FORCE: loads are ignored"));
  EXPECT_TRUE(test::has_note(deck, "CBEND: unsupported element"));
  EXPECT_TRUE(test::has_note(deck, "ZZTOP: unknown card"));
  EXPECT_TRUE(test::has_note(deck, "CWHAT"));
  EXPECT_FALSE(test::has_note(deck, "EIGRL"));
  for (const auto& note : deck.notes)
    if (note.what == "FORCE") {
      EXPECT_EQ(note.count, 2u);
      EXPECT_EQ(note.where.line, 5);
    }
}

TEST(NastranIncludes, AreFollowedFromFileToFile) {
  std::map<std::string, std::string> files = {{"run/sub/nodes.bdf", "GRID,1\ninclude '../more/\n   masses.bdf'\n"},
                                              {"run/more/masses.bdf", "CONM2,1,1,,4.\nCELAS2,2,1.,1,1\n"},
                                              {"run/ring.bdf", "INCLUDE \"ring.bdf\"\nGRID,1\n"}};
  const NastranIncludes load = [&](const std::filesystem::path& path) {
    const auto file = files.find(path.generic_string());
    if (file == files.end()) throw InvalidInput("no such file", "", "");
    return file->second;
  };
  const auto deck =
      parse_nastran("SOL 103\nCEND\nBEGIN BULK\nINCLUDE 'sub\\nodes.bdf'\nENDDATA\nGRID,99\n", "run/main.dat", load);
  EXPECT_EQ(deck.model.mesh.node_count(), 1);
  EXPECT_DOUBLE_EQ(deck.model.masses.at(0).mass, 4.0);
  for (const auto& [text, part] :
       {std::pair{"INCLUDE ring.bdf\n", "includes itself"}, {"INCLUDE 'none.bdf'\nGRID,1\n", "cannot be read"}})
    try {
      parse_nastran(text, "run/main.dat", load);
      FAIL() << text;
    } catch (const InvalidInput& error) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
}

TEST(NastranCaseControl, ChoosesSupports) {
  const std::string bulk =
      "GRID,1\nGRID,2\nCELAS2,1,1.,1,1,2,1\nCONM2,2,1,,1.\nCONM2,3,2,,1.\nSPC1,1,123456,1\nSPC1,2,123456,2\nSPCADD,3,1,"
      "2\n";
  const auto held = [&](const std::string& control) {
    std::string names;
    for (const auto& [name, nodes] : test::nastran(control + bulk).model.mesh.node_sets) names += name + " ";
    return names;
  };
  const std::string begin = "CEND\nBEGIN BULK\n";
  EXPECT_EQ(held("SOL 103\nCEND\nSPC = 1\nBEGIN BULK\n"), "spc1 ");
  EXPECT_EQ(held("SOL 103\nCEND\nSPC=3\nBEGIN BULK\n"), "spc1 spc2 ");
  EXPECT_EQ(held("SOL 103\nCEND\n SUBCASE 1\n  SPC = 2\n SUBCASE 2\n  SPC = 1\nBEGIN BULK\n"), "spc2 ");
  EXPECT_EQ(held("SOL 103\nCEND\nMETHOD = 1\nBEGIN BULK\n"), "");  // as Nastran: none is chosen
  EXPECT_EQ(held(""), "spc1 spc2 ");                               // bulk data alone: the only sum
}

}  // namespace
}  // namespace kalfem
