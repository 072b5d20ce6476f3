// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "base/absent.hpp"
#include "base/data_folder.hpp"
#include "base/figures.hpp"
#include "updating_case.hpp"

// `kalfem update` as a user runs it.

namespace kalfem::test {
namespace {

/// A held chain of three masses whose frequencies are known in closed form: omega_j = 2 sqrt(k / m) sin((2 j - 1) pi /
/// 14) with k = 1 kN/m and m = 1 kg.
const std::string modal_case = R"(kalfem: 1
substructures:
  frame:
    masses: {1: 1 kg, 2: 1 kg, 3: 1 kg}
    springs:
      - {name: s1, from: ground, to: 1, stiffness: 1.3 kN/m}
      - {name: s2, from: 1, to: 2, stiffness: 0.8 kN/m}
      - {name: s3, from: 2, to: 3, stiffness: 1.1 kN/m}
update:
  parameters:
    frame.s1.stiffness: {bounds: [0.2 kN/m, 5 kN/m]}
    frame.s2.stiffness: {}
    frame.s3.stiffness: {}
  compare:
    modes: {modes: frame, frequencies: [2.2398607, 6.2759501, 9.0690107], deviation: 0.1 %}
    push: {static: frame, loads: {3: 10 N}, displacements: {1: 10 mm, 2: 20 mm, 3: 30 mm}, deviation: 0.1 %}
  check_sensitivities: true
modifications:
  heavier: {substructure: frame, set: {3.mass: 2 kg}, modes: 2}
)";

TEST(Updating, FrequenciesAndAStaticTestGiveTheSpringsBack) {
  const ScratchFolder folder("update-modal");
  const auto outcome =
      run_command("update " + written(folder, modal_case).string() + " --out " + folder.path().string(), folder);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const auto updating = read_summary(folder)["updating"];
  for (const std::string spring : {"frame.s1.stiffness", "frame.s2.stiffness", "frame.s3.stiffness"}) {
    // The frequencies are given to seven digits, which leave 1e-5.
    EXPECT_NEAR(updating["parameters"][spring]["estimate"].get<double>(), 1000.0, 4e-5) << spring;
    EXPECT_GT(updating["parameters"][spring]["std"].get<double>(), 0.0);
    EXPECT_EQ(updating["sensitivities"][spring]["verdict"], "agrees with differences");
  }
  EXPECT_TRUE(updating["converged"].get<bool>());
  EXPECT_LT(updating["residual_final"].get<double>(), 2e-5);  // of deviations of .1 %: found 7e-6
  EXPECT_GT(updating["residual_initial"].get<double>(), 1.0);
  // Masses of 1, 1 and 2 kg on the same springs: the lowest root of det(K - omega^2 M) = 0.
  const auto heavier = read_summary(folder)["prediction"]["heavier"]["frequencies_hz"];
  ASSERT_EQ(heavier.size(), 2U);
  EXPECT_NEAR(heavier[0].get<double>(), 1.7915777, 1e-7);
  EXPECT_NE(outcome.output.find("Updated parameters"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder / "update.checkpoint.json"));
  EXPECT_TRUE(std::filesystem::exists(folder / "results.h5"));
}

TEST(Updating, EveryMethodFindsTheSame) {
  const ScratchFolder folder("update-methods");
  std::string text = modal_case;
  text.replace(text.find("    frame.s2.stiffness: {}"), 26, "    frame.s2.stiffness: {bounds: [0.2 kN/m, 5 kN/m]}");
  text.replace(text.find("    frame.s3.stiffness: {}"), 26, "    frame.s3.stiffness: {bounds: [0.2 kN/m, 5 kN/m]}");
  for (const std::string method : {"method: cma_es", "starts: 5"}) {
    std::string other = text;
    other.replace(other.find("check_sensitivities: true"), 25, method);
    const auto outcome =
        run_command("update " + written(folder, other).string() + " --out " + folder.path().string(), folder);
    ASSERT_EQ(outcome.code, 0) << outcome.errors;
    const auto updating = read_summary(folder)["updating"];
    const auto& parameters = updating["parameters"];
    if (method == "starts: 5") {
      ASSERT_EQ(updating["minima"].size(), 1U) << updating["minima"];
      EXPECT_EQ(updating["minima"][0]["starts"], 5);
      EXPECT_EQ(updating["minima"][0]["parameters"]["frame.s2.stiffness"],
                parameters["frame.s2.stiffness"]["estimate"]);
    }
    for (const auto& [name, parameter] : parameters.items())
      // found 6e-6 of it: where the generations end
      EXPECT_NEAR(parameter["estimate"].get<double>(), 1000.0, 0.01) << method << " " << name;
  }
}

/// A displacement that was read in another place: no springs give it together with the frequencies.
TEST(Updating, ThatContradictsTheStatedDeviationsIsUnusable) {
  const ScratchFolder folder("update-contradiction");
  std::string text = modal_case;
  text.replace(text.find("3: 30 mm"), 8, "3: 20 mm");
  const auto outcome =
      run_command("update " + written(folder, text).string() + " --out " + folder.path().string(), folder);
  EXPECT_EQ(outcome.code, 3) << outcome.errors;
  EXPECT_NE(outcome.errors.find("comparison 'push' still differs"), std::string::npos) << outcome.errors;
  const auto summary = read_summary(folder);
  EXPECT_EQ(summary["verdict"]["state"], "unusable");
  const auto& reason = summary["verdict"]["reasons"][0];
  EXPECT_EQ(reason["code"], "residual_large");
  EXPECT_EQ(summary["message"], reason["text"].get<std::string>() + "; " + reason["remedy"].get<std::string>());
}

struct UpdateMistake {
  const char* name;
  std::string from, to;
  std::vector<std::string> messages;
};

class UpdatingMistake : public testing::TestWithParam<UpdateMistake> {};

TEST_P(UpdatingMistake, IsOneClearMessage) {
  const auto& mistake = GetParam();
  const ScratchFolder folder(std::string("update-bad-") + mistake.name);
  std::string text = modal_case;
  const auto place = text.find(mistake.from);
  ASSERT_NE(place, std::string::npos);
  text.replace(place, mistake.from.size(), mistake.to);
  const auto outcome =
      run_command("update " + written(folder, text).string() + " --out " + (folder / "out").string(), folder);
  EXPECT_EQ(outcome.code, 2) << outcome.errors;
  for (const auto& piece : mistake.messages) EXPECT_NE(outcome.errors.find(piece), std::string::npos) << outcome.errors;
  EXPECT_FALSE(std::filesystem::exists(folder / "out" / "summary.json"));
}

INSTANTIATE_TEST_SUITE_P(
    Mistakes, UpdatingMistake,
    testing::Values(
        UpdateMistake{"UnknownParameter",
                      "frame.s2.stiffness: {}",
                      "frame.s4.stiffness: {}",
                      {"case.yaml:12", "frame.s4.stiffness", "did you mean"}},
        UpdateMistake{"NamedTwice",
                      "frame.s2.stiffness: {}",
                      "twice: {applies_to: [frame.s1.stiffness]}",
                      {"case.yaml:12", "frame.s1.stiffness", "already"}},
        UpdateMistake{"BoundsExcludeTheStart",
                      "[0.2 kN/m, 5 kN/m]",
                      "[2 kN/m, 5 kN/m]",
                      {"case.yaml:11", "1300", "outside its bounds"}},
        UpdateMistake{"BoundsTheWrongWay", "[0.2 kN/m, 5 kN/m]", "[5 kN/m, 0.2 kN/m]", {"case.yaml:11", "lower bound"}},
        UpdateMistake{"WrongUnit", "[0.2 kN/m, 5 kN/m]", "[0.2 kg, 5 kN/m]", {"case.yaml:11", "N/m"}},
        UpdateMistake{"NothingDependsOnIt",
                      "frame.s2.stiffness: {}",
                      "frame.damping.mass_factor: {initial: 1}",
                      {"frame.damping.mass_factor"}},
        UpdateMistake{
            "UnknownSubstructure", "{modes: frame,", "{modes: frame2,", {"case.yaml:15", "did you mean 'frame'"}},
        UpdateMistake{"MoreModesThanThereAre", "9.0690107]", "9.0690107, 15, 20]", {"case.yaml:15", "15"}},
        UpdateMistake{"UnknownPoint", "displacements: {1: 10 mm,", "displacements: {4: 10 mm,", {"case.yaml:16", "4"}},
        UpdateMistake{"UnknownModification", "3.mass: 2 kg", "4.mass: 2 kg", {"case.yaml:19", "frame.4.mass"}},
        UpdateMistake{
            "NeedsARecord",
            "push: {static: frame, loads: {3: 10 N}, displacements: {1: 10 mm, 2: 20 mm, 3: 30 mm}, deviation: 0.1 %}",
            "push: {time_history: frame}",
            {"case.yaml:16", "record"}}),
    [](const auto& each) { return each.param.name; });

class UpdatingOnData : public testing::Test {
protected:
  static nlohmann::json run(const std::string& name) {
    const ScratchFolder folder("update-data");
    const auto outcome = run_command("run " + example(name) + " --out " + folder.path().string(), folder);
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    return read_summary(folder);
  }
};

TEST_F(UpdatingOnData, SouthamptonFrequenciesAreTheMeasuredPeaks) {
  if (!std::filesystem::exists(data_folder("southampton-3storey")))
    KALFEM_ABSENT("no southampton-3storey in " + data_folder().string());
  const auto parameters = run("southampton/southampton.yaml")["updating"]["parameters"];
  // Frequencies of three equal masses on these springs against the peaks of the measured responses.
  Eigen::Matrix3d stiffness = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 3; ++i) {
    const auto& storey = parameters["frame.storey_" + std::to_string(i + 1) + ".stiffness"];
    const double k = storey["estimate"].get<double>();
    EXPECT_GT(storey["std"].get<double>(), 0.0);
    stiffness(i, i) += k;
    if (i == 0) continue;
    stiffness(i - 1, i - 1) += k;
    stiffness(i, i - 1) -= k;
    stiffness(i - 1, i) -= k;
  }
  const Eigen::Vector3d values = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(stiffness / 5.201).eigenvalues();
  const Eigen::Vector3d peaks{6.514, 17.464, 26.506};
  double worst = 0.0;
  for (int i = 0; i < 3; ++i) worst = std::max(worst, std::abs(std::sqrt(values[i]) / (2.0 * M_PI) / peaks[i] - 1.0));
  EXPECT_LT(worst, 0.002);  // a fit of all lines and the peaks differ by .07 %
  expect_figure("southampton.frequencies", worst);
  // ratios of the three modes scatter by 5e-4; one for all is found with a deviation of 2e-5
  EXPECT_NEAR(parameters["frame.damping.modal"]["estimate"].get<double>(), 0.002, 3e-4);
}

}  // namespace
}  // namespace kalfem::test
