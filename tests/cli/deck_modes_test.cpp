#include <gtest/gtest.h>

#include <numbers>

#include "command.hpp"

namespace kalfem::test {
namespace {

/// Two masses of 2 kg and 1 kg on springs of 800 and 200 N/m in a row, along x.
const std::string two_masses = R"(SOL 103
BEGIN BULK
GRID,1,,0.,0.,0.,,123456
GRID,2,,1.,0.,0.,,23456
GRID,3,,2.,0.,0.,,23456
CELAS2,1,800.,1,1,2,1
CELAS2,2,200.,2,1,3,1
CONM2,11,2,,2.
CONM2,12,3,,1.
ENDDATA
)";

/// Roots of det(K - w^2 M) = 2 w^4 - 1400 w^2 + 160000.
double frequency(int mode) {
  const double root = std::sqrt(1400.0 * 1400.0 - 8.0 * 160000.0);
  return std::sqrt((1400.0 + (mode == 1 ? -root : root)) / 4.0) / (2.0 * std::numbers::pi);
}

TEST(DeckModes, AreThoseOfTheWholeDeck) {
  const ScratchFolder folder("deck-modes-alone");
  const std::string deck = (folder / "two.bdf").string();
  std::ofstream(deck) << two_masses;
  const auto outcome = run_command("modes " + deck + " --modes 2 --json", folder);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const auto json = nlohmann::json::parse(outcome.output);
  ASSERT_EQ(json["frequencies_hz"].size(), 2U);
  for (int mode : {1, 2}) EXPECT_NEAR(json["frequencies_hz"][mode - 1].get<double>(), frequency(mode), 1e-9);
  EXPECT_EQ(json["dofs"], 2);
  const auto table = run_command("modes " + deck + " --modes 2 --out " + (folder / "out").string(), folder);
  ASSERT_EQ(table.code, 0) << table.errors;
  EXPECT_NE(table.output.find("frequency [Hz]"), std::string::npos) << table.output;
  EXPECT_TRUE(std::filesystem::exists(folder / "out" / "two_modes.vtu"));
  EXPECT_EQ(run_command("modes " + deck + " --modes 2", folder).code, 0);
  EXPECT_FALSE(std::filesystem::exists(folder / "two.kalfem-out"));
}

// In tonnes, millimetres and seconds stiffness has the number of N/mm.
TEST(DeckModes, CountTheUnits) {
  const ScratchFolder folder("deck-modes-units");
  const std::string deck = (folder / "two.bdf").string();
  std::ofstream(deck) << two_masses;
  const auto outcome = run_command("modes " + deck + " --units mm t s --modes 2 --json", folder);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const auto json = nlohmann::json::parse(outcome.output);
  EXPECT_NEAR(json["frequencies_hz"][0].get<double>(), frequency(1), 1e-9);
  EXPECT_NEAR(json["mass"].get<double>(), 3000.0, 1e-9);
  EXPECT_EQ(run_command("modes " + deck + " --units mm t", folder).code, 2);
  EXPECT_EQ(run_command("modes " + deck + " --set a=1", folder).code, 2);
}

TEST(DeckModes, RefuseWhatTheDeckNeedsAndKalfemDoesNotRead) {
  const ScratchFolder folder("deck-modes-missing");
  const std::string deck = (folder / "two.bdf").string();
  std::string text = two_masses;
  std::ofstream(deck) << text.replace(text.find("CONM2,11"), 0, "CWELD,9,1,2\n");
  const auto outcome = run_command("modes " + deck, folder);
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.errors.find("CWELD"), std::string::npos) << outcome.errors;
  EXPECT_EQ(run_command("modes " + (folder / "none.bdf").string(), folder).code, 2);
}

}  // namespace
}  // namespace kalfem::test
