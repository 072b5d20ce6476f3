// SPDX-License-Identifier: Apache-2.0
// Models without places, elements, masses, springs, sensors or samples: a clear word, and no crash.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "command.hpp"

namespace kalfem::test {
namespace {

class EmptySets : public testing::Test {
protected:
  std::string write(const std::string& text, const std::string& name) {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }
  /// Ends as the contract says: done or refused, in words.
  Outcome run(const std::string& arguments) {
    const auto outcome = run_command(arguments, folder_);
    EXPECT_TRUE(outcome.code == 0 || outcome.code == 2) << arguments << "\n" << outcome.errors;
    if (outcome.code == 2) EXPECT_NE(outcome.errors + outcome.output, "") << arguments;
    EXPECT_EQ(outcome.errors.find("internal error"), std::string::npos) << outcome.errors;
    return outcome;
  }

  ScratchFolder folder_{"empty-sets"};
};

const std::string scalar_points =
    "SOL 103\nCEND\nBEGIN BULK\nSPOINT,2,3\nCELAS4,1,1000.,2\nCELAS4,2,2000.,2,3\nCMASS4,3,2.0,2\nCMASS4,4,1.0,3\n"
    "ENDDATA\n";

// Roots of 2 w^4 - 7000 w^2 + 2e6.
TEST_F(EmptySets, ScalarPointsAloneAreAModel) {
  const std::string deck = write(scalar_points, "scalar.bdf");
  const auto outcome = run("modes " + deck + " --modes 2 --json");
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const auto json = nlohmann::json::parse(outcome.output);
  const double root = std::sqrt(7000.0 * 7000.0 - 8 * 2e6);
  for (int mode : {0, 1})
    EXPECT_NEAR(json["frequencies_hz"][mode].get<double>(),
                std::sqrt((7000.0 + (mode == 0 ? -root : root)) / 4.0) / (2.0 * std::numbers::pi), 1e-9);
  EXPECT_NEAR(json["mass"].get<double>(), 3.0, 1e-12);
  const auto checked = run("check " + deck);
  EXPECT_EQ(checked.code, 0) << checked.output;
  EXPECT_NE(checked.output.find("8.98"), std::string::npos) << checked.output;
  EXPECT_EQ(checked.output.find("coincide"), std::string::npos) << checked.output;
}

/// A scalar point stands nowhere, also where a grid point stands at the origin.
TEST_F(EmptySets, ScalarPointsHaveNoPlace) {
  const auto checked =
      run("check " + write("SOL 103\nCEND\nBEGIN BULK\nGRID,1,,0.,0.,0.,,23456\nGRID,4,,5.,0.,0.,,123456\n"
                           "SPOINT,2,3\nCELAS2,1,1000.,1,1,4,1\nCELAS2,2,10.,2,,1,1\nCELAS4,5,10.,2,3\n"
                           "CONM2,3,1,,2.0\nCMASS4,4,1.0,2\nCMASS4,6,1.,3\nENDDATA\n",
                           "beside.bdf"));
  EXPECT_EQ(checked.output.find("coincide"), std::string::npos) << checked.output;
}

/// Decks that each lack one kind of thing, through what the command does with a deck.
TEST_F(EmptySets, OfDecksEndInWords) {
  const std::map<std::string, std::string> decks = {
      {"no points", "SOL 103\nCEND\nBEGIN BULK\nMAT1,1,1.,,.3,1.\nENDDATA\n"},
      {"points alone", "SOL 103\nCEND\nBEGIN BULK\nGRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nENDDATA\n"},
      {"one scalar point", "SOL 103\nCEND\nBEGIN BULK\nSPOINT,1\nENDDATA\n"},
      {"mass alone", "SOL 103\nCEND\nBEGIN BULK\nGRID,1,,0.,0.,0.\nCONM2,2,1,,3.\nENDDATA\n"},
      {"springs alone", "SOL 103\nCEND\nBEGIN BULK\nSPOINT,1,2\nCELAS4,1,5.,1,2\nENDDATA\n"},
      {"all held",
       "SOL 103\nCEND\nSPC = 1\nBEGIN BULK\nGRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nCROD,1,1,1,2\nPROD,1,1,1.\n"
       "MAT1,1,1.,,.3,1.\nSPC1,1,123456,1,2\nENDDATA\n"},
      {"scalar points held",
       "SOL 103\nCEND\nSPC = 1\nBEGIN BULK\nSPOINT,1\nCELAS4,1,5.,1\nCMASS4,2,1.,1\nSPC1,1,0,1\n"
       "ENDDATA\n"},
      {"scalar masses alone", "SOL 103\nCEND\nBEGIN BULK\nSPOINT,1,2\nCMASS4,1,5.,1,2\nENDDATA\n"}};
  for (const auto& [name, text] : decks) {
    SCOPED_TRACE(name);
    const std::string deck = write(text, "deck.bdf");
    run("check " + deck);
    run("modes " + deck);
    const std::string file = write(
        "kalfem: 1\nsubstructures:\n  s:\n    finite_elements: {deck: deck.bdf}\nstatic:\n  substructure: s\n"
        "  cases: {g: {gravity: [0, 0, -9.81]}}\n",
        "case.yaml");
    for (const char* verb : {"check ", "modes ", "static "}) run(verb + file);
  }
}

/// Scalar points under a load: 10 N on two springs in a row.
TEST_F(EmptySets, ScalarPointsAreLoaded) {
  write(
      "SOL 101\nCEND\nLOAD = 9\nBEGIN BULK\nSPOINT,1,2\nCELAS4,1,1000.,1\nCELAS4,2,500.,1,2\nSLOAD,9,2,10.\nENDDATA\n",
      "scalar.bdf");
  const std::string file = write(
      "kalfem: 1\nsubstructures:\n  s:\n    finite_elements: {deck: scalar.bdf, nodes: {end: 2}}\nstatic:\n"
      "  substructure: s\n  deck_cases: true\n",
      "case.yaml");
  const auto outcome = run("static " + file + " --out " + (folder_ / "out").string());
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const auto statics = read_summary(folder_ / "out")["statics"];
  EXPECT_NEAR(statics["subcase1"]["displacements"]["end"]["x"].get<double>(), 0.03, 1e-12) << statics;
}

/// Springs alone have no cells, and their static fields show the lines between the nodes.
TEST_F(EmptySets, SpringsAloneHaveStaticFields) {
  write(
      "SOL 101\nCEND\nBEGIN BULK\nGRID,1,,0.,0.,0.,,123456\nGRID,2,,1.,0.,0.,,23456\nCELAS2,1,800.,1,1,2,1\n"
      "CONM2,2,2,,1.\nENDDATA\n",
      "springs.bdf");
  const std::string file = write(
      "kalfem: 1\nsubstructures:\n  s:\n    finite_elements: {deck: springs.bdf, nodes: {end: 2}}\nstatic:\n"
      "  substructure: s\n  cases: {pull: {forces: [{at: end, force: [8, 0, 0]}]}}\n",
      "case.yaml");
  const auto outcome = run("static " + file + " --out " + (folder_ / "out").string());
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const std::string fields = read(folder_ / "out" / "s_static.vtu");
  EXPECT_NE(fields.find("pull: displacement"), std::string::npos);
  EXPECT_NE(fields.find("NumberOfCells=\"1\""), std::string::npos);
}

/// A record without samples, and a case without sensors.
TEST_F(EmptySets, OfCasesEndInWords) {
  const std::string structure =
      "kalfem: 1\nsubstructures:\n  s:\n    masses: {m: 1 kg}\n    springs: [{from: ground, to: m, "
      "stiffness: 100 N/m, damping: 1}]\n";
  write("t,a\n", "empty.csv");
  const std::map<std::string, std::string> cases = {
      {"no sensors", structure + "simulate: {duration: 1 s, sample_rate: 100 Hz}\n"},
      {"no samples",
       structure + "sensors:\n  a: {at: s.m, quantity: acceleration, noise: 1e-3}\nmeasured:\n  file: empty.csv\n"},
      {"no masses", "kalfem: 1\nsubstructures:\n  s:\n    springs: [{from: ground, to: m, stiffness: 100}]\n"},
      {"no substructures", "kalfem: 1\nsubstructures: {}\n"}};
  for (const auto& [name, text] : cases) {
    SCOPED_TRACE(name);
    const std::string file = write(text, "case.yaml");
    for (const char* verb : {"check ", "modes ", "simulate ", "run "})
      run(verb + file + (verb == std::string("check ") ? "" : " --out " + (folder_ / "out").string()));
  }
}

}  // namespace
}  // namespace kalfem::test
