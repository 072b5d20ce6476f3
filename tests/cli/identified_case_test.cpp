// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "short_case.hpp"

namespace kalfem::test {
namespace {

TEST(IdentifiedCaseOfARun, ChecksAndSimulatesWithTheEstimates) {
  const ScratchFolder folder("identified");
  const auto file = write_case(folder, "case.yaml", short_case("identified"));
  ASSERT_EQ(run_command("run " + file + " --out " + (folder / "out").string(), folder).code, 0);
  const auto first = read_summary(folder / "out");
  EXPECT_EQ(first["identified"]["file"], "case.identified.yaml");
  EXPECT_TRUE(first["identified"]["notes"].empty());
  const double estimate = first["parameters"]["suspension.k"]["estimate"].get<double>();
  const std::string identified = (folder / "out" / "case.identified.yaml").string();
  const auto checked = run_command("check " + identified, folder);
  EXPECT_EQ(checked.code, 0) << checked.errors;
  const auto again = run_command("run " + identified + " --out " + (folder / "again").string(), folder);
  EXPECT_EQ(again.code, 0) << again.errors;
  const auto second = read_summary(folder / "again");
  const auto& parameter = second["parameters"]["suspension.k"];
  EXPECT_EQ(parameter["true"].get<double>(), estimate);
  EXPECT_EQ(parameter["initial"].get<double>(), estimate);
}

TEST(IdentifiedCaseOfARun, IsRemovedByAnUnusableOne) {
  const ScratchFolder folder("not-identified");
  const std::string out = " --out " + (folder / "out").string();
  std::string text = short_case("unusable");
  ASSERT_EQ(run_command("run " + write_case(folder, "case.yaml", text) + out, folder).code, 0);
  ASSERT_TRUE(std::filesystem::exists(folder / "out" / "case.identified.yaml"));
  const std::string usual = "{initial: 4 kN/m, std: 20 %}";
  text.replace(text.find(usual), usual.size(), "{initial: 60 kN/m, std: 10 N/m}");
  const auto outcome = run_command("run " + write_case(folder, "case.yaml", text) + out, folder);
  EXPECT_EQ(outcome.code, 3) << outcome.output;
  EXPECT_FALSE(std::filesystem::exists(folder / "out" / "case.identified.yaml"));
  EXPECT_FALSE(read_summary(folder / "out").contains("identified"));
}

}  // namespace
}  // namespace kalfem::test
