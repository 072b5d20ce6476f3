// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "command.hpp"

namespace kalfem::test {
namespace {

const std::string sound_case = R"(kalfem: 1
substructures:
  wheel: {masses: {w: 1.5 kg}, springs: [{from: ground, to: w, stiffness: 20 kN/m}]}
  body: {chain: {masses: 2, mass: 1 kg, stiffness: 30 kN/m}, damping: {modal: 1 %}}
connectors:
  suspension: {from: wheel.w, to: body.1, law: linear, parameters: {k: 5 kN/m, c: 10 N s/m}}
excitation:
  road: {base_displacement: wheel.ground, random: {rms: 3 mm, band: [0.5, 30 Hz]}}
sensors:
  a: {acceleration: body.2, noise: 15 %}
simulate: {duration: 2 s, sample_rate: 1 kHz}
estimate: {unknown: {suspension.k: {initial: 4 kN/m, std: 20 %}}, settle: 0.1 s}
)";

struct CaseMistake {
  const char* name;
  std::string from, to;               ///< what is changed in the sound case
  std::vector<std::string> messages;  ///< pieces that the errors must hold
  int code = 2;
};

class BadInput : public testing::TestWithParam<CaseMistake> {};

TEST_P(BadInput, IsOneClearMessageAndNothingIsLeft) {
  const auto& mistake = GetParam();
  const ScratchFolder folder(std::string("bad-") + mistake.name);
  std::string text = sound_case;
  const auto place = text.find(mistake.from);
  ASSERT_NE(place, std::string::npos);
  text.replace(place, mistake.from.size(), mistake.to);
  std::ofstream(folder / "case.yaml") << text;
  for (const std::string verb : {"run", "check"}) {
    const auto outcome = run_command(verb + " " + (folder / "case.yaml").string(), folder);
    EXPECT_EQ(outcome.code, mistake.code) << outcome.errors;
    for (const auto& piece : mistake.messages)
      EXPECT_NE(outcome.errors.find(piece), std::string::npos) << outcome.errors;
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "case.kalfem-out"));
}

INSTANTIATE_TEST_SUITE_P(
    Mistakes, BadInput,
    testing::Values(CaseMistake{"UnknownKey",
                                "simulate: {duration",
                                "simulate: {durations",
                                {"case.yaml:11", "durations", "did you mean 'duration'"}},
                    CaseMistake{"WrongUnit", "rms: 3 mm", "rms: 3 kg", {"case.yaml:8", "3 kg", "excitation.road"}},
                    CaseMistake{"WrongParameterUnit", "k: 5 kN/m, c", "k: 5 kN, c", {"case.yaml:6", "N/m"}},
                    CaseMistake{"NegativeMass", "w: 1.5 kg", "w: -1.5 kg", {"case.yaml:3", "-1.5"}},
                    CaseMistake{"NotANumber", "w: 1.5 kg", "w: nan", {"case.yaml:3", "nan"}},
                    CaseMistake{"MissingFile",
                                "random: {rms: 3 mm, band: [0.5, 30 Hz]}",
                                "file: nowhere.csv, channel: r",
                                {"case.yaml:8", "nowhere.csv"}},
                    CaseMistake{"SensorWithoutDof",
                                "acceleration: body.2",
                                "acceleration: body.3",
                                {"case.yaml:10", "body.3", "did you mean"}},
                    CaseMistake{"ConnectorWithoutPoint",
                                "to: body.1",
                                "to: bodi.1",
                                {"case.yaml:6", "bodi.1", "did you mean 'body.1'"}},
                    CaseMistake{"DampedTwice",
                                "connectors:",
                                "damping: {modal: 2 %}\nconnectors:",
                                {"case.yaml:5", "damped twice", "'body'"}},
                    CaseMistake{"UnknownLaw", "law: linear", "law: liner", {"case.yaml:6", "did you mean 'linear'"}},
                    CaseMistake{"MissingParameter",
                                "law: linear, parameters: {k: 5 kN/m, c: 10 N s/m}",
                                "law: saturating, parameters: {k: 5 kN/m}",
                                {"case.yaml:6", "'mu_k1' is missing"}},
                    CaseMistake{"UnknownUnknown",
                                "suspension.k: {",
                                "suspension.kk: {",
                                {"case.yaml:12", "suspension.kk", "did you mean 'suspension.k'"}},
                    CaseMistake{"NoNoise", "noise: 15 %", "noise: 0 %", {"case.yaml:10", "noise"}},
                    CaseMistake{"TwoAtOnce",
                                "simulate: {duration: 2 s, sample_rate: 1 kHz}",
                                "simulate: {duration: -1 s, sample_rate: 1 m}",
                                {"duration", "sample_rate"}},
                    CaseMistake{"NoSyntax", "kalfem: 1", "kalfem: [1", {"case.yaml"}}),
    [](const auto& each) { return std::string(each.param.name); });

TEST(Command, SoundCaseRuns) {
  const ScratchFolder folder("sound");
  std::ofstream(folder / "case.yaml") << sound_case;
  const auto outcome = run_command("run " + (folder / "case.yaml").string(), folder);
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_EQ(outcome.errors, "");
  EXPECT_TRUE(std::filesystem::exists(folder / "case.kalfem-out" / "summary.json"));
}

TEST(Command, MissingCaseFileIsTheUsersToMend) {
  const ScratchFolder folder("missing");
  const auto outcome = run_command("run " + (folder / "none.yaml").string(), folder);
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.errors.find("none.yaml"), std::string::npos);
}

TEST(Command, FolderThatCannotBeMadeIsNamed) {
  const ScratchFolder folder("folder");
  std::ofstream(folder / "case.yaml") << sound_case;
  const auto outcome =
      run_command("run " + (folder / "case.yaml").string() + " --out " + (folder / "case.yaml" / "x").string(), folder);
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.errors.find("--out"), std::string::npos) << outcome.errors;
}

TEST(Command, SchemaIsJson) {
  const ScratchFolder folder("schema");
  const auto outcome = run_command("schema --json", folder);
  EXPECT_EQ(outcome.code, 0);
  EXPECT_TRUE(nlohmann::json::parse(outcome.output).contains("properties"));
}

TEST(Command, ResponseWithoutBoundIsNotUsable) {
  const ScratchFolder folder("unstable");
  std::string text = sound_case;
  const std::string law = "law: linear, parameters: {k: 5 kN/m, c: 10 N s/m}";
  text.replace(text.find(law), law.size(), "law: expression, force: \"k*x^3 - c*v\", parameters: {k: -5e9, c: 1e5}");
  text.replace(text.find("estimate:"), std::string::npos, "");
  std::ofstream(folder / "case.yaml") << text;
  const auto outcome = run_command("run " + (folder / "case.yaml").string(), folder);
  EXPECT_EQ(outcome.code, 3) << outcome.errors;
  EXPECT_EQ(read_summary(folder / "case.kalfem-out")["status"], "unusable");
}

}  // namespace
}  // namespace kalfem::test
