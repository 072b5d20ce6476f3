// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <fstream>

#include "base/scratch_folder.hpp"
#include "command.hpp"

namespace kalfem::test {
namespace {

/// A frame in mm that no turn takes to itself, of rods.
constexpr const char* deck = R"(*NODE
1, 0, 0, 0
2, 2000, 0, 0
3, 2000, 1000, 0
4, 0, 1000, 3000
5, 500, 0, 0
*ELEMENT, TYPE=T3D2, ELSET=rod
1, 1, 5
2, 5, 2
3, 2, 3
4, 3, 4
5, 4, 1
*MATERIAL, NAME=steel
*ELASTIC
210000, 0.3
*DENSITY
7.85e-9
*SOLID SECTION, ELSET=rod, MATERIAL=steel
100
)";

struct MatchCommand : testing::Test {
  MatchCommand() : folder("match") { write("frame.inp", deck); }
  void write(const std::string& name, const std::string& text) const { std::ofstream(folder / name) << text; }
  [[nodiscard]] std::string of(const std::string& name) const { return (folder / name).string(); }
  const ScratchFolder folder;
};

// The test's x, y, z are the model's y, -x, z, in metres, from another origin.
TEST_F(MatchCommand, FindsNodesAndSaysHowSensorsLook) {
  write("sensors.csv", "name,x,y,z\n11,5,5,5\n12,5,3,5\n13,6,3,5\n14,6,5,8\n15,5,4.5,5\n");
  const std::string call = "match " + of("sensors.csv") + " " + of("frame.inp") + " --units mm t s";
  const auto outcome = run_command(call + " --page " + of("match.html"), folder);
  ASSERT_EQ(outcome.code, 0) << outcome.errors << outcome.output;
  EXPECT_NE(outcome.output.find("nodes: {p11: 1, p12: 2, p13: 3, p14: 4, p15: 5}"), std::string::npos)
      << outcome.output;
  EXPECT_NE(outcome.output.find("p11.y: \"11:+X\", p11.x: \"11:-Y\", p11.z: \"11:+Z\""), std::string::npos)
      << outcome.output;
  EXPECT_NE(read(folder / "match.html").find("Points on the model"), std::string::npos);
  const auto json = nlohmann::json::parse(run_command(call + " --json", folder).output);
  EXPECT_EQ(json["points"][4]["node"], 5);
  EXPECT_NEAR(json["fit"]["rms_m"].get<double>(), 0.0, 1e-9);
  EXPECT_TRUE(json["other_fits"].empty());
}

TEST_F(MatchCommand, ReadsTheNodesOfAUniversalFile) {
  std::string text = "    -1\n    15\n";
  for (const char* row : {"11 0 0 0 5. 5. 5.", "12 0 0 0 5. 3. 5.", "13 0 0 0 6. 3. 5.", "14 0 0 0 6. 5. 8."})
    text += std::string("         ") + row + "\n";
  write("test.unv", text + "    -1\n");
  const auto outcome = run_command("match " + of("test.unv") + " " + of("frame.inp") + " --units mm t s", folder);
  EXPECT_NE(outcome.output.find("p14: 4"), std::string::npos) << outcome.output << outcome.errors;
}

TEST_F(MatchCommand, SaysThatANodeIsNotSure) {
  // A flat set of points: a turn by half about their plane's axes is as good.
  write("flat.csv", "a,5,5,5\nb,7,5,5\nc,7,6,5\nd,5.5,5,5\n");
  std::string flat =
      "*NODE\n1, 0, 0, 0\n2, 0.5, 0, 0\n3, 1.5, 0, 0\n4, 2, 0, 0\n5, 2, 1, 0\n6, 1.5, 1, 0\n7, 0.5, 1, 0\n8, 0, 1, 0\n"
      "*ELEMENT, TYPE=T3D2, ELSET=rod\n";
  for (int i = 1; i <= 8; ++i)
    flat += std::to_string(i) + ", " + std::to_string(i) + ", " + std::to_string(i % 8 + 1) + "\n";
  write("flat.inp", flat + std::string(deck).substr(std::string(deck).find("*MATERIAL")));
  const auto outcome = run_command("match " + of("flat.csv") + " " + of("flat.inp"), folder);
  EXPECT_EQ(outcome.code, 3) << outcome.errors;
  EXPECT_NE(outcome.output.find("The structure allows 3 other positions as well"), std::string::npos) << outcome.output;
  EXPECT_NE(outcome.output.find("Not sure: a, b, c, d"), std::string::npos) << outcome.output;
}

TEST_F(MatchCommand, RefusesRowsThatAreNoPoints) {
  write("bad.csv", "a,1,2\nb,1,2,x\nc,1,2,3\nc,1,2,3\nd,1,2,3,1,0,0,0,1,0,0,1,0\n");
  const auto outcome = run_command("match " + of("bad.csv") + " " + of("frame.inp"), folder);
  EXPECT_EQ(outcome.code, 2);
  for (const char* words : {"bad.csv:1: the row has 3 cells", "bad.csv:2: 'x' is not a number", "'c' is given twice",
                            "the axes of 'd' are not right-handed"})
    EXPECT_NE(outcome.errors.find(words), std::string::npos) << words << "\n" << outcome.errors;
  EXPECT_EQ(run_command("match " + of("bad.csv") + " " + of("bad.csv"), folder).code, 2);
}

}  // namespace
}  // namespace kalfem::test
