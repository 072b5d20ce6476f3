// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "short_case.hpp"

namespace kalfem::test {
namespace {

bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

std::string with_unknown(const std::string& prior) {
  std::string text = short_case("verdict");
  const std::string usual = "suspension.k: {initial: 4 kN/m, std: 20 %}";
  return text.replace(text.find(usual), usual.size(), "suspension.k: " + prior);
}

TEST(VerdictOfARun, IsConsistentWithTheRightModel) {
  const ScratchFolder folder("verdict-consistent");
  const auto file = write_case(folder, "case.yaml", short_case("verdict"));
  const auto outcome = run_command("run " + file + " --strict --out " + (folder / "out").string(), folder);
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_TRUE(holds(outcome.output, "Verdict: consistent")) << outcome.output;
  const auto summary = read_summary(folder / "out");
  EXPECT_EQ(summary["verdict"]["state"], "consistent");
  EXPECT_TRUE(summary["verdict"]["reasons"].empty());
  const auto& parameter = summary["parameters"]["suspension.k"];
  // Half a second has some tens of independent scores: the robust deviation scatters by a fifth.
  EXPECT_NEAR(parameter["std_robust"].get<double>() / parameter["std"].get<double>(), 1.0, 0.3);
  EXPECT_LT(std::abs(summary["estimation"]["innovation_correlation"]["a"].get<double>()), 0.2);
  EXPECT_TRUE(holds(read(folder / "out" / "report.html"), "Results consistent"));
}

/// A prior so narrow that the record adds nothing to it.
TEST(VerdictOfARun, IsSuspiciousWhereTheRecordTellsNothing) {
  const ScratchFolder folder("verdict-suspicious");
  const auto file = write_case(folder, "case.yaml", with_unknown("{initial: 5 kN/m, std: 0.1 N/m}"));
  const std::string arguments = "run " + file + " --out " + (folder / "out").string();
  const auto outcome = run_command(arguments, folder);
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_TRUE(holds(outcome.output, "Verdict: suspicious")) << outcome.output;
  EXPECT_TRUE(holds(outcome.errors, "the record says nothing about unknown 'suspension.k'")) << outcome.errors;
  const auto summary = read_summary(folder / "out");
  EXPECT_EQ(summary["status"], "ok");
  EXPECT_EQ(summary["verdict"]["state"], "suspicious");
  const auto& reason = summary["verdict"]["reasons"][0];
  EXPECT_EQ(reason["code"], "not_identified");
  EXPECT_EQ(reason["subject"], "suspension.k");
  EXPECT_EQ(run_command(arguments + " --strict", folder).code, 3);
}

/// A narrow prior far from the truth: the filter keeps it, and its innovations say that it is wrong.
TEST(VerdictOfARun, IsUnusableWhereTheNumbersContradictThemselves) {
  const ScratchFolder folder("verdict-unusable");
  const auto file = write_case(folder, "case.yaml", with_unknown("{initial: 60 kN/m, std: 10 N/m}"));
  const auto outcome = run_command("run " + file + " --out " + (folder / "out").string(), folder);
  EXPECT_EQ(outcome.code, 3) << outcome.output;
  const auto summary = read_summary(folder / "out");
  EXPECT_EQ(summary["status"], "unusable");
  EXPECT_EQ(summary["verdict"]["state"], "unusable");
  EXPECT_FALSE(summary["message"].get<std::string>().empty());
  EXPECT_TRUE(holds(read(folder / "out" / "report.html"), "Results unusable"));
}

}  // namespace
}  // namespace kalfem::test
