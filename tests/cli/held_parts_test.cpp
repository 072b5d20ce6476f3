// SPDX-License-Identifier: Apache-2.0
// Parts of one substructure that each are held, or that a connector of the case joins; sensors at numbered nodes.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "command.hpp"

namespace kalfem::test {
namespace {

/// Two bars of four CBAR each along x, 1 m long; the first one is clamped, the second one if `both`.
std::string two_bars(bool both) {
  std::string deck =
      "SOL 103\nCEND\nSPC = 5\nBEGIN BULK\nPARAM,COUPMASS,1\nPBAR,1,1,1.E-4,1.E-9,2.E-9,3.E-9\n"
      "MAT1,1,2.E11,,.3,7800.\n";
  for (const int first : {1, 11}) {
    for (int i = 0; i <= 4; ++i)
      deck += "GRID," + std::to_string(first + i) + ",," + std::to_string(0.25 * i) + "," + (first == 1 ? "0." : "3.") +
              ",0.\n";
    for (int i = 0; i < 4; ++i)
      deck += "CBAR," + std::to_string(first + i) + ",1," + std::to_string(first + i) + "," +
              std::to_string(first + i + 1) + ",0.,1.,0.\n";
    if (first == 1 || both) deck += "SPC1,5,123456," + std::to_string(first) + "\n";
  }
  return deck + "ENDDATA\n";
}

const std::string joined_case = R"(kalfem: 1
substructures:
  s:
    finite_elements:
      deck: bars.bdf
      nodes: {n3: 3, tip: 5, n12: 12, end: 15}
connectors:
  one: {from: s.n3.y, to: s.n12.y, law: linear, parameters: {k: 1e4, c: 5}}
  two: {from: s.tip.y, to: s.end.y, law: linear, parameters: {k: 1e4, c: 5}}
excitation:
  push: {force: s.end.y, random: {rms: 1 N, band: [0.5, 30 Hz], fade_in: 0.05 s}}
sensors:
  a: {acceleration: s.tip.y, noise: 5 %}
simulate: {duration: 0.1 s, sample_rate: 1 kHz}
)";

class HeldParts : public testing::Test {
protected:
  Outcome run(const std::string& verb, const std::string& text, bool both) {
    std::ofstream(folder_ / "bars.bdf") << two_bars(both);
    std::ofstream(folder_ / "case.yaml") << text;
    return run_command(verb + " " + (folder_ / "case.yaml").string(), folder_);
  }
  ScratchFolder folder_{"held-parts"};
};

TEST_F(HeldParts, AreModesBesideEachOther) {
  std::ofstream(folder_ / "bars.bdf") << two_bars(true);
  const auto outcome = run_command("modes " + (folder_ / "bars.bdf").string() + " --modes 2 --json", folder_);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const auto found = nlohmann::json::parse(outcome.output)["frequencies_hz"];
  const double expected =
      std::pow(1.8751040687, 2) / (2.0 * std::numbers::pi) * std::sqrt(2e11 * 1e-9 / (7800.0 * 1e-4));
  for (int i : {0, 1}) EXPECT_NEAR(found[i].get<double>(), expected, 1e-3 * expected);
  const auto checked = run_command("check " + (folder_ / "bars.bdf").string(), folder_);
  EXPECT_EQ(checked.code, 0) << checked.output;
  EXPECT_EQ(checked.output.find("warning"), std::string::npos) << checked.output;
}

TEST_F(HeldParts, AreRefusedWhereOneHangsOnNothing) {
  std::ofstream(folder_ / "bars.bdf") << two_bars(false);
  const auto outcome = run_command("modes " + (folder_ / "bars.bdf").string(), folder_);
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.errors.find("2 unconnected parts"), std::string::npos) << outcome.errors;
}

TEST_F(HeldParts, MayBeJoinedByConnectorsOfTheCase) {
  const auto checked = run("check", joined_case, false);
  EXPECT_EQ(checked.code, 0) << checked.errors;
  EXPECT_EQ(checked.output.find("consists of 2 unconnected parts"), std::string::npos) << checked.output;
  const auto simulated = run("simulate", joined_case, false);
  EXPECT_EQ(simulated.code, 0) << simulated.errors;
}

/// A node that has the name of its number is a place behind a reduction too.
TEST_F(HeldParts, SensorsStandAtNumberedNodesBehindAReduction) {
  std::string text = joined_case;
  text.replace(text.find("s.tip.y, noise"), 14, "s.n4.y, noise");
  text.replace(text.find("n3: 3,"), 6, "n3: 3, n4: 4,");
  text.insert(text.find("connectors:"), "    reduction: {modes: 6}\n");
  const auto outcome = run("check", text, true);
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  const auto simulated = run("simulate", text, true);
  ASSERT_EQ(simulated.code, 0) << simulated.errors;
}

/// Statics alone need no density.
TEST_F(HeldParts, OfStaticsNeedNoDensity) {
  std::string deck = two_bars(true);
  deck.replace(deck.find(",7800."), 6, "");
  std::ofstream(folder_ / "light.bdf") << deck;
  const std::string text =
      "kalfem: 1\nsubstructures:\n  s:\n    finite_elements: {deck: light.bdf, nodes: {tip: 5}}\nstatic:\n"
      "  substructure: s\n  cases: {pull: {forces: [{at: tip, force: [0, 30, 0]}]}}\n";
  const auto checked = run("check", text, true);
  EXPECT_EQ(checked.code, 0) << checked.errors;
  EXPECT_EQ(checked.output.find("error:"), std::string::npos) << checked.output;
  const auto solved = run("static", text, true);
  ASSERT_EQ(solved.code, 0) << solved.errors;
  EXPECT_NEAR(read_summary(folder_ / "case.kalfem-out")["statics"]["pull"]["displacements"]["tip"]["y"].get<double>(),
              30.0 / (3.0 * 2e11 * 1e-9), 1e-9);
}

}  // namespace
}  // namespace kalfem::test
