// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "base/figures.hpp"
#include "base/places.hpp"
#include "updating_case.hpp"

// Models that are refined by records: driven by the estimated motion of a boundary, or simulated as a whole.

namespace kalfem::test {
namespace {

TEST(UpdatingByRecords, TheChainIsRefinedByItsOwnRecord) {
  const ScratchFolder folder("update-chain");
  const auto outcome =
      run_command("update " + example("chain/update.yaml") + " --out " + folder.path().string(), folder);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const auto summary = read_summary(folder);
  const auto& refined = summary["updating"]["parameters"];
  // two to three times what docs/figures.txt states
  EXPECT_LT(relative_error(refined["body.3-4.stiffness"]), 0.0015);
  EXPECT_LT(relative_error(refined["body.7-8.stiffness"]), 0.0015);
  EXPECT_LT(relative_error(refined["body.damping.modal"]), 0.005);
  EXPECT_LT(relative_error(summary["parameters"]["suspension.mu_k1"]), 0.006);
  EXPECT_LT(relative_error(summary["parameters"]["suspension.mu_c1"]), 0.015);
  for (const std::string name : {"body.3-4.stiffness", "body.7-8.stiffness", "body.damping.modal"})
    expect_figure("chain_update." + name, signed_error(refined[name]));
  for (const std::string name : {"suspension.mu_k1", "suspension.mu_c1"})
    expect_figure("chain_update." + name, relative_error(summary["parameters"][name]));
  expect_figure("chain_update.stages", static_cast<double>(summary["updating"]["stages"].size()));
  // What is left is the sensors' noise.
  EXPECT_GT(summary["updating"]["residual_initial"].get<double>(), 1.5);
  // found 9e-4
  EXPECT_NEAR(summary["updating"]["residual_final"].get<double>(), 1.0, 0.005);
  // A line on the terminal for each iteration, and its trace.
  const auto iterations = summary["updating"]["stages"].size();
  EXPECT_GE(iterations, 3U);
  for (std::size_t i = 1; i <= iterations; ++i)
    EXPECT_NE(outcome.output.find("iteration " + std::string(i < 10 ? " " : "") + std::to_string(i) + ":"),
              std::string::npos);
  EXPECT_NE(read(folder / "report.html").find("Parameters by iteration"), std::string::npos);
}

/// Both ways of differentiating the boundary's motion end at the same place.
TEST(UpdatingByRecords, HeldGainsFindWhatFilterPassesFind) {
  const ScratchFolder folder("update-gains");
  const auto text = changed(short_chain(), "body.7-8.stiffness: {initial: 24 kN/m}\n    ", "");
  const auto passes = updated(folder, text)["updating"];
  const auto held = updated(
      folder, changed(text, "{time_history: body}", "{time_history: body, derivatives: held_gains}"))["updating"];
  for (const auto& [name, parameter] : passes["parameters"].items()) {
    const double difference = held["parameters"][name]["estimate"].get<double>() - parameter["estimate"].get<double>();
    // Gauss-Newton with approximate derivatives ends where J^T r = 0 for its own J: within the parameter's deviation.
    EXPECT_LT(std::abs(difference), 0.2 * parameter["std"].get<double>()) << name;
    EXPECT_NEAR(held["parameters"][name]["std"].get<double>(), parameter["std"].get<double>(),
                0.1 * parameter["std"].get<double>());
  }
  EXPECT_LE(held["evaluations"].get<int>(), passes["evaluations"].get<int>() + 1);
  EXPECT_EQ(passes["comparisons"]["record"]["derivatives"], "filter passes");
  EXPECT_EQ(held["comparisons"]["record"]["derivatives"], "held gains, not compared with filter passes");
}

TEST(UpdatingByRecords, TheSimulationOfTheWholeRefinesTheSameModel) {
  const ScratchFolder folder("update-simulation");
  const auto summary = updated(folder, changed(short_chain(), "{time_history: body}", "{simulation: all}"));
  for (const auto& [name, parameter] : summary["updating"]["parameters"].items())
    EXPECT_LT(relative_error(parameter), name == "body.damping.modal" ? 0.005 : 0.001) << name;  // found 1e-3 and 3e-4
  // found 3e-3
  EXPECT_NEAR(summary["updating"]["residual_final"].get<double>(), 1.0, 0.01);
}

/// The base is shaken as a whole: motion is relative to it, sensors see the sum.
TEST(UpdatingByRecords, OverAnAcceleratedBaseTheTruthLeavesTheNoise) {
  const ScratchFolder folder("update-base");
  const auto text = changed(changed(short_chain(), "base_displacement: wheel.ground", "base_acceleration: all"),
                            "random: {rms: 3 mm,", "random: {rms: 3 m/s^2,");
  const auto summary = updated(folder, text);
  for (const auto& [name, parameter] : summary["updating"]["parameters"].items())
    EXPECT_LT(relative_error(parameter), name == "body.damping.modal" ? 0.015 : 0.01) << name;  // found 4e-3 and 5e-3
  // found 2e-3
  EXPECT_NEAR(summary["updating"]["residual_final"].get<double>(), 1.0, 0.01);
}

TEST(UpdatingByRecords, ARunThatWasKilledGoesOnWhereItStood) {
  const ScratchFolder folder("update-killed");
  const auto file = written(folder, changed(short_chain(), "duration: 6 s", "duration: 3 s")).string();
  const auto whole = run_command("update " + file + " --out " + (folder / "whole").string(), folder);
  ASSERT_EQ(whole.code, 0) << whole.errors;
  const std::string out = (folder / "killed").string(), checkpoint = out + "/update.checkpoint.json";
  const std::string script =
      command_file() + " update " + file + " --out " + out + " >/dev/null 2>&1 & p=$!; i=0; while [ ! -f " +
      checkpoint + " ] && [ $i -lt 1200 ]; do sleep 0.05; i=$((i+1)); done; kill -9 $p; wait $p 2>/dev/null; true";
  ASSERT_EQ(std::system(script.c_str()), 0);
  ASSERT_TRUE(std::filesystem::exists(checkpoint)) << "the run ended before it could be killed";
  const auto second = run_command("update " + file + " --out " + out, folder);
  ASSERT_EQ(second.code, 0) << second.errors;
  const auto one = read_summary(folder / "whole")["updating"], other = read_summary(folder / "killed")["updating"];
  EXPECT_GE(other["resumed_at"].get<int>(), 1);
  EXPECT_EQ(one["evaluations"], other["evaluations"]);
  for (const auto& [name, parameter] : one["parameters"].items())
    EXPECT_EQ(parameter["estimate"], other["parameters"][name]["estimate"]) << name;
}

TEST(UpdatingByRecords, ADamagedCheckpointIsNotUsed) {
  const ScratchFolder folder("update-damaged");
  auto text = changed(changed(short_chain(), "body.7-8.stiffness: {initial: 24 kN/m}\n    ", ""),
                      "{time_history: body}", "{simulation: all}");
  text = changed(text, "duration: 6 s", "duration: 3 s");
  for (const std::string content : {"{", "{}", R"({"fingerprint": "", "state": {}, "trace": []})"}) {
    std::ofstream(folder / "update.checkpoint.json") << content;
    EXPECT_FALSE(updated(folder, text)["updating"].contains("resumed_at")) << content;
  }
}

/// E and wall of two regions of the coarse vehicle; the one of the examples is the same on a finer mesh.
TEST(UpdatingByRecords, AShellFrameIsRefinedThroughItsSuperelements) {
  const ScratchFolder folder("update-vehicle");
  auto text = changed(read(example("vehicle/update.yaml")), "${MESH:-frame.msh}", example("vehicle/small.msh"));
  text = changed(changed(text, "${DURATION:-5} s", "4 s"), "tolerance: 1e-3", "tolerance: 1e-2");
  const auto summary = updated(folder, text);
  for (const auto& [name, parameter] : summary["updating"]["parameters"].items())
    EXPECT_LT(relative_error(parameter), 0.005) << name;  // found 2.6e-3, 1.4 standard deviations
  // The largest relative error with held gains, found .21, is above the limit.
  EXPECT_NE(summary["updating"]["comparisons"]["record"]["derivatives"].get<std::string>().find(
                "filter passes: derivatives with held gains would differ by up to"),
            std::string::npos);
  const auto& suspension = summary["parameters"]["suspension_2.mu_k1"];
  EXPECT_LT(relative_error(suspension), 0.008);  // two standard deviations; found 3.5e-3
  // Without the loop the suspension takes the blame for the frame.
  const double without = summary["updating"]["unknowns_without_updating"]["suspension_2.mu_k1"].get<double>();
  EXPECT_GT(std::abs(without / 30.0 - 1.0), 0.2);
}

}  // namespace
}  // namespace kalfem::test
