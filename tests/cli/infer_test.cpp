// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <csignal>

#include "base/places.hpp"
#include "command.hpp"
#include "started_command.hpp"

// The verb `infer`: its files, its refusals, and a record without a determined answer.

namespace kalfem::test {
namespace {

using Json = nlohmann::json;

const std::string oscillator = R"(kalfem: 1
substructures: {s: {masses: {m: 2 kg}, springs: [{name: k, from: ground, to: m, stiffness: 600 N/m, damping: 4}]}}
connectors: {c: {from: s.ground, to: s.m, law: linear, parameters: {k: 200 N/m}}}
excitation: {f: {force: s.m, random: {rms: 10 N, band: [0.5, 10 Hz], seed: 4}}}
sensors: {a: {acceleration: s.m, noise: 5 %}}
simulate: {duration: 4 s, sample_rate: 100 Hz}
)";

const std::string one_unknown =
    "estimate: {diagnose: false, settle: 0.2 s, unknown: {c.k: {initial: 180, std: 20 %}}}\n";
const std::string two_springs =
    "estimate: {diagnose: false, settle: 0.2 s, unknown: {c.k: {initial: 200, std: 20 %}, s.k.stiffness: {initial: "
    "600, "
    "std: 20 %}}}\n";

/// A summary but for the times that were taken, and what an earlier run left to this one, which stands with them.
Json without_times(Json json) {
  if (json.is_object()) {
    json.erase("seconds");
    json.erase("timing");
  }
  for (auto& item : json)
    if (item.is_structured()) item = without_times(item);
  return json;
}

class Infer : public testing::Test {
protected:
  Outcome run(const std::string& text, const std::string& verb = "infer") {
    const std::string file = (folder_ / "case.yaml").string();
    std::ofstream(file) << text;
    return run_command(verb + " " + file + (verb == "check" ? "" : " --out " + (folder_ / "out").string()), folder_);
  }
  [[nodiscard]] Json inference() const { return read_summary(folder_ / "out")["inference"]; }

  ScratchFolder folder_{"infer"};
};

TEST_F(Infer, WritesThePosterior) {
  const auto outcome = run(oscillator + one_unknown + "infer: {samples: 200, predictions: 5, profile: c.k}\n");
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_NE(outcome.output.find("The data determine"), std::string::npos) << outcome.output;
  const Json found = inference();
  const Json parameter = found["parameters"]["c.k"];
  EXPECT_NEAR(parameter["mean"].get<double>(), 200.0, 4.0 * parameter["std"].get<double>());
  EXPECT_LT(found["pareto_k"].get<double>(), 0.7);
  EXPECT_TRUE(found["profiles"]["c.k"]["interval_95"][0].is_number());
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out" / "results.h5"));
  EXPECT_NE(read(folder_ / "out" / "report.html").find("c.k"), std::string::npos);
}

// Killed at a likelihood, the run goes on from there and ends with the same bits.
TEST_F(Infer, ContinuesAKilledRun) {
  const std::string text = oscillator + one_unknown + "infer: {samples: 400, predictions: 0, profile: c.k}\n";
  ASSERT_EQ(run(text).code, 0);
  const Json whole = without_times(read_summary(folder_ / "out"));
  const std::string series = read(folder_ / "out" / "results.h5");
  std::filesystem::remove_all(folder_ / "out");
  const auto checkpoint = folder_ / "out" / "infer.checkpoint";
  const pid_t child =
      start({command_file(), "infer", (folder_ / "case.yaml").string(), "--out", (folder_ / "out").string()});
  std::error_code not_yet;
  while (!std::filesystem::exists(checkpoint) || std::filesystem::file_size(checkpoint, not_yet) < 8000)
    ASSERT_EQ(waitpid(child, nullptr, WNOHANG), 0) << "it ended before it could be killed";
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  ASSERT_TRUE(std::filesystem::exists(checkpoint));
  std::ofstream(checkpoint, std::ios::app) << "a line cut sho";
  const auto outcome = run(text);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const Json summary = read_summary(folder_ / "out");
  EXPECT_EQ(without_times(summary), whole);
  EXPECT_TRUE(read(folder_ / "out" / "results.h5") == series);
  EXPECT_EQ(read(folder_ / "out" / "report.html").find("from an earlier run"), std::string::npos);
  EXPECT_GT(summary["timing"]["infer_evaluations_from_earlier_run"].get<int>(), 50);
  EXPECT_FALSE(std::filesystem::exists(checkpoint));
}

TEST_F(Infer, IsPartOfRun) {
  ASSERT_EQ(run(oscillator + one_unknown + "infer: {samples: 100, predictions: 0}\n", "run").code, 0);
  EXPECT_TRUE(inference().is_object());
  ASSERT_EQ(run(oscillator + one_unknown + "infer: {samples: 100, predictions: 0}\n", "estimate").code, 0);
  EXPECT_FALSE(inference().is_object());
}

// Two springs side by side: only their sum is seen.
TEST_F(Infer, SaysWhatTheRecordCannotTellBeforeTheRunAndAfter) {
  const auto check = run(oscillator + two_springs + "infer: {}\n", "check");
  ASSERT_EQ(check.code, 0) << check.errors;
  EXPECT_NE(check.output.find("cannot be told apart"), std::string::npos) << check.output;
  const auto outcome = run(oscillator + two_springs + "infer: {samples: 300, predictions: 0}\n");
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const Json found = inference();
  EXPECT_NE(found["identifiability"]["after"]["text"].get<std::string>().find("cannot be told apart"),
            std::string::npos);
  EXPECT_LT(found["correlation"]["matrix"][0][1].get<double>(), -0.95);
}

TEST_F(Infer, NeedsItsSection) {
  const auto outcome = run(oscillator + one_unknown);
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.errors.find("the case has no `infer`"), std::string::npos) << outcome.errors;
}

}  // namespace
}  // namespace kalfem::test
