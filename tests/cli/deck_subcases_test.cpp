// SPDX-License-Identifier: Apache-2.0
// Decks by the command: the preload of their modes, subcases that differ, other analyses, and what a case takes of it.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "command.hpp"

namespace kalfem::test {
namespace {

constexpr int elements = 16;
constexpr double modulus = 2e11, area = 2.5e-5, inertia = 5.2e-11, density = 7800.0, pull = 2e4;

/// A beam of 1 m, simply supported, that the static subcase pulls.
std::string pulled_beam(const std::string& control) {
  std::string deck = "SOL 103\nCEND\nSPC = 5\nSUBCASE 1\n  LOAD = 7\nSUBCASE 2\n  METHOD = 9\n" + control +
                     "BEGIN BULK\nPBAR,1,1,2.5E-5,5.2E-11,5.2E-11,1.E-10\nMAT1,1,2.E11,,.3,7800.\nEIGRL,9,,,6\n"
                     "SPC1,5,1234,1\nSPC1,5,23,17\nFORCE,7,17,,20000.,1.,0.,0.\n";
  for (int i = 0; i <= elements; ++i)
    deck += "GRID," + std::to_string(i + 1) + ",," + std::to_string(static_cast<double>(i) / elements) + ",0.,0.\n";
  for (int i = 1; i <= elements; ++i) {
    const std::string number = std::to_string(i);
    deck += "CBAR," + number + ",1," + number + "," + std::to_string(i + 1) + ",0.,1.,0.\n";
  }
  return deck + "ENDDATA\n";
}

/// n / 2 sqrt((T + n^2 pi^2 E I) / rho A) of a simply supported beam of length 1.
double frequency(int n, double tension) {
  const double stiffness = tension + std::pow(n * std::numbers::pi, 2) * modulus * inertia;
  return 0.5 * n * std::sqrt(stiffness / (density * area));
}

class DeckSubcases : public testing::Test {
protected:
  std::string write(const std::string& text, const std::string& name = "deck.bdf") {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }
  Outcome run(const std::string& arguments) { return run_command(arguments, folder_); }
  [[nodiscard]] std::vector<double> modes(const std::string& text, const std::string& options = "") {
    const auto outcome = run("modes " + write(text) + " --modes 6 --json " + options);
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    return nlohmann::json::parse(outcome.output)["frequencies_hz"].get<std::vector<double>>();
  }

  ScratchFolder folder_{"deck-subcases"};
};

// Two directions of bending, alike: every second frequency is the next one.
TEST_F(DeckSubcases, PreloadOfStatsubIsThatOfTheModes) {
  const auto stiffened = modes(pulled_beam("  STATSUB = 1\n")), slack = modes(pulled_beam(""));
  for (int n = 1; n <= 3; ++n) {
    EXPECT_NEAR(stiffened[static_cast<std::size_t>(2 * n - 2)], frequency(n, pull), 2e-3 * frequency(n, pull));
    EXPECT_NEAR(slack[static_cast<std::size_t>(2 * n - 2)], frequency(n, 0.0), 2e-3 * frequency(n, 0.0));
  }
  EXPECT_NEAR(modes(pulled_beam("  STATSUB = 1\n"), "--subcase 1")[0], slack[0], 1e-9 * slack[0]);
  const auto checked = run("check " + write(pulled_beam("  STATSUB(PRELOAD) = 1\n")));
  EXPECT_EQ(checked.code, 0) << checked.output;
  EXPECT_NE(checked.output.find("with the preload that the deck states, load case 'subcase1'"), std::string::npos);
  EXPECT_EQ(checked.output.find("FORCE"), std::string::npos) << checked.output;
}

TEST_F(DeckSubcases, PreloadOfStatsubIsThatOfACase) {
  write(pulled_beam("  STATSUB = 1\n"));
  const std::string file =
      write("kalfem: 1\nsubstructures:\n  beam:\n    finite_elements:\n      deck: deck.bdf\n      nodes: {mid: 9}\n",
            "case.yaml");
  const auto outcome = run("modes " + file + " --json");
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const auto frequencies = nlohmann::json::parse(outcome.output)["model"]["substructures"]["beam"]["frequencies_hz"];
  EXPECT_NEAR(frequencies[0].get<double>(), frequency(1, pull), 2e-3 * frequency(1, pull));
  const std::string slack = write(
      "kalfem: 1\nsubstructures:\n  beam:\n    finite_elements:\n      deck: deck.bdf\n      subcase: 1\n"
      "      nodes: {mid: 9}\n",
      "slack.yaml");
  const auto without = run("modes " + slack + " --json");
  ASSERT_EQ(without.code, 0) << without.errors;
  EXPECT_NEAR(
      nlohmann::json::parse(without.output)["model"]["substructures"]["beam"]["frequencies_hz"][0].get<double>(),
      frequency(1, 0.0), 2e-3 * frequency(1, 0.0));
}

TEST_F(DeckSubcases, ThatDifferAskWhichOneIsMeant) {
  std::string text = pulled_beam("  SPC = 6\n");
  text.insert(text.find("SPC1,5"), "SPC1,6,123456,1\n");
  text.replace(text.find("  LOAD = 7"), 10, "  METHOD = 9");
  const auto refused = run("modes " + write(text));
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.errors.find("the SPC of SUBCASE 2"), std::string::npos) << refused.errors;
  EXPECT_NE(refused.errors.find("--subcase 2"), std::string::npos) << refused.errors;
  const double clamped =
      std::pow(1.8751040687, 2) / (2 * std::numbers::pi) * std::sqrt(modulus * inertia / (density * area));
  EXPECT_NEAR(modes(text, "--subcase 2")[0], clamped, 5e-3 * clamped);
  EXPECT_NEAR(modes(text, "--subcase 1")[0], frequency(1, 0.0), 2e-3 * frequency(1, 0.0));
}

TEST_F(DeckSubcases, OfStaticsNeedNoMass) {
  std::string text = pulled_beam("");
  text.replace(text.find("SOL 103"), 7, "SOL 101");
  text.replace(text.find(",7800."), 6, "");
  const auto checked = run("check " + write(text));
  EXPECT_EQ(checked.code, 0) << checked.output;
  EXPECT_NE(checked.output.find("SOL 101 (statics)"), std::string::npos) << checked.output;
  EXPECT_NE(checked.output.find("statics need none"), std::string::npos) << checked.output;
  text.replace(text.find("SOL 101"), 7, "SOL 103");
  EXPECT_EQ(run("check " + write(text)).code, 2);
}

}  // namespace
}  // namespace kalfem::test
