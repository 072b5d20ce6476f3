#include <gtest/gtest.h>

#include "command.hpp"

namespace kalfem::test {
namespace {

const std::string simulated = R"(kalfem: 1
substructures:
  wheel: {masses: {w: 1.5 kg}, springs: [{from: ground, to: w, stiffness: 20 kN/m, damping: 10}]}
excitation:
  push: {force: wheel.w, sine: {amplitude: 1 N, frequency: 3 Hz}}
sensors:
  a: {acceleration: wheel.w, noise: 5 %}
simulate: {duration: 0.2 s, sample_rate: 100 Hz, tolerance: 0.1}
)";

TEST(Verbs, RefuseACaseWithoutTheirSection) {
  const ScratchFolder folder("verbs");
  const std::string file = (folder / "case.yaml").string();
  std::ofstream(file) << simulated;
  for (const std::string verb : {"estimate", "predict", "update"}) {
    const auto outcome = run_command(verb + " " + file, folder);
    EXPECT_EQ(outcome.code, 2) << verb;
    EXPECT_NE(outcome.errors.find("case.yaml:1: the case has no `" + verb + "`"), std::string::npos) << outcome.errors;
    EXPECT_FALSE(std::filesystem::exists(folder / "case.kalfem-out"));
  }
  EXPECT_EQ(run_command("simulate " + file, folder).code, 0);
  EXPECT_EQ(run_command("modes " + file, folder).code, 0);
  EXPECT_EQ(run_command("run " + file, folder).code, 0);
  std::ofstream(file) << simulated.substr(0, simulated.find("simulate:"));
  EXPECT_EQ(run_command("simulate " + file, folder).code, 2);
}

TEST(Verbs, LeaveNothingWhereTheInputIsRefused) {
  const ScratchFolder folder("nothing-left");
  const std::string file = (folder / "case.yaml").string();
  std::ofstream(file) << simulated << "report: {displacements: wheel.v}\n";
  const auto run = run_command("run " + file, folder), check = run_command("check " + file, folder);
  EXPECT_EQ(run.code, 2);
  EXPECT_EQ(check.code, 2);
  EXPECT_EQ(run.errors, check.errors);
  EXPECT_NE(run.errors.find("case.yaml:9: report.displacements: there is no point 'wheel.v'"), std::string::npos)
      << run.errors;
  EXPECT_FALSE(std::filesystem::exists(folder / "case.kalfem-out"));
}

TEST(Verbs, SayWhichKeysHaveNoEffect) {
  const ScratchFolder folder("without-effect");
  const std::string file = (folder / "case.yaml").string();
  std::string text = simulated;
  text.replace(text.find("tolerance"), 0, "hht_alpha: -0.1, ");
  std::ofstream(file) << text;
  for (const std::string verb : {"run ", "check "}) {
    const auto outcome = run_command(verb + file, folder);
    EXPECT_EQ(outcome.code, 0);
    EXPECT_NE(outcome.errors.find("line 8: simulate.hht_alpha has no effect"), std::string::npos) << outcome.errors;
  }
}

}  // namespace
}  // namespace kalfem::test
