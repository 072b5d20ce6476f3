// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "command.hpp"

namespace kalfem::test {
namespace {

/// Two seconds at 100 Hz: a sine of 5 Hz that is clipped at 0.8, and a dead channel.
std::string table() {
  std::string text = "t [s],a [g],dead\n";
  for (int k = 0; k < 200; ++k)
    text +=
        std::to_string(0.01 * k) + "," + std::to_string(std::min(0.8, std::sin(0.1 * 3.14159265 * k + 0.1))) + ",7\n";
  return text;
}

struct Inspect : testing::Test {
  Inspect() : folder("inspect"), file((folder / "run.csv").string()) { std::ofstream(file) << table(); }
  ScratchFolder folder;
  std::string file;
};

TEST_F(Inspect, TellsWhatAFileHoldsAndWhatIsOdd) {
  const auto outcome = run_command("inspect " + file, folder);
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  for (const std::string words : {"2 channels", "a: clipped above at 0.8 g", "dead: 7 throughout"})
    EXPECT_NE(outcome.output.find(words), std::string::npos) << words << "\n" << outcome.output;
}

TEST_F(Inspect, WritesJsonForPrograms) {
  const auto outcome = run_command("inspect --json " + file, folder);
  const auto json = nlohmann::json::parse(outcome.output);
  ASSERT_EQ(json.size(), 1u);
  const auto& channel = json[0]["channels"][0];
  EXPECT_EQ(channel["name"], "a");
  EXPECT_EQ(channel["unit"], "g");
  EXPECT_EQ(channel["samples"], 200);
  EXPECT_NEAR(channel["time"]["rate_hz"].get<double>(), 100.0, 1e-6);
  EXPECT_NEAR(channel["frequencies"][0]["frequency_hz"].get<double>(), 5.0, 0.05);
  EXPECT_EQ(channel["clipped_above"]["level"], 0.8);
  EXPECT_TRUE(json[0]["channels"][1]["dead"].get<bool>());
}

TEST_F(Inspect, WritesAPageWithTheCourseOfEachChannel) {
  const auto page = folder / "page.html";
  EXPECT_EQ(run_command("inspect " + file + " --page " + page.string(), folder).code, 0);
  const auto html = read(page);
  EXPECT_NE(html.find("clipped above"), std::string::npos);
  EXPECT_NE(html.find("\"y_label\":\"a [g]\""), std::string::npos);
}

TEST_F(Inspect, ShowsTheOtherFilesWhereOneIsBroken) {
  const auto broken = (folder / "broken.lvm").string();
  std::ofstream(broken) << "LabVIEW Measurement\t\nSepar";
  const auto outcome = run_command("inspect " + broken + " " + file, folder);
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.errors.find("broken.lvm"), std::string::npos);
  EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1) << outcome.errors;
  EXPECT_NE(outcome.output.find("run.csv"), std::string::npos);
}

}  // namespace
}  // namespace kalfem::test
