// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <thread>

#include "base/places.hpp"
#include "command.hpp"
#include "started_command.hpp"

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

/// The last line of a check counts what stands above it.
TEST(Verbs, CheckCountsWhatItFound) {
  const ScratchFolder folder("check-counts");
  ASSERT_EQ(run_command("new measured " + (folder / "car").string(), folder).code, 0);
  const std::string check = "check " + (folder / "car/case.yaml").string();
  const auto gap = run_command(check, folder), unit = run_command(check + " --set sensors.body.unit=g", folder);
  EXPECT_TRUE(gap.output.ends_with("1 remark. Nothing was run.\n")) << gap.output;
  EXPECT_NE(unit.output.find("its rms is 10.4"), std::string::npos) << unit.output;
  EXPECT_TRUE(unit.output.ends_with("1 question, 1 remark. Nothing was run.\n")) << unit.output;
}

TEST(Verbs, TellTheOneThatWasMeant) {
  const ScratchFolder folder("verb-meant");
  const auto outcome = run_command("updat case.yaml", folder);
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.errors.find("there is no verb 'updat' (did you mean 'update'?)"), std::string::npos)
      << outcome.errors;
}

// Each starter runs at once and passes.
TEST(Verbs, WriteACaseToStartFrom) {
  const ScratchFolder folder("new");
  for (const std::string kind : {"chain", "component", "measured", "plate", "vehicle"}) {
    const std::string place = (folder / kind).string();
    const auto written = run_command("new " + kind + " " + place, folder);
    ASSERT_EQ(written.code, 0) << written.errors;
    EXPECT_NE(written.output.find("Next: kalfem run " + place + "/case.yaml"), std::string::npos) << written.output;
    EXPECT_TRUE(nlohmann::json::parse(read(folder / kind / "kalfem.schema.json")).contains("properties"));
    const auto outcome = run_command("run " + place + "/case.yaml --quiet", folder);
    EXPECT_EQ(outcome.code, 0) << kind << outcome.errors;
    EXPECT_EQ(outcome.output, "Verdict: consistent\n") << kind << outcome.errors;
    const auto again = run_command("new " + kind + " " + place, folder);
    EXPECT_EQ(again.code, 2);
    EXPECT_NE(again.errors.find("case.yaml is there already"), std::string::npos) << again.errors;
  }
  const auto parameters = read_summary(folder / "measured" / "case.kalfem-out")["parameters"];
  EXPECT_NEAR(parameters["suspension.k"]["estimate"].get<double>(), 18e3, 100.0);
  EXPECT_NEAR(parameters["sensors.body.delay"]["estimate"].get<double>(), 8e-3, 1e-4);
  EXPECT_NEAR(parameters["sensors.body.offset"]["estimate"].get<double>(), 0.15, 0.005);
  EXPECT_EQ(run_command("new plane " + (folder / "plane").string(), folder).code, 2);
}

TEST(Verbs, TellOneSectionOfTheCaseFile) {
  const ScratchFolder folder("schema-section");
  const auto place = run_command("schema place", folder);
  EXPECT_EQ(place.code, 0);
  EXPECT_NE(place.output.find("candidates"), std::string::npos);
  EXPECT_EQ(place.output.find("base_displacement"), std::string::npos);
  const auto wrong = run_command("schema estimat", folder);
  EXPECT_EQ(wrong.code, 2);
  EXPECT_NE(wrong.errors.find("did you mean 'estimate'"), std::string::npos) << wrong.errors;
}

TEST(Verbs, AreCompletedByShells) {
  const ScratchFolder folder("completion");
  const auto script = run_command("completion bash", folder);
  ASSERT_EQ(script.code, 0);
  std::ofstream(folder / "completion.sh") << script.output;
  const auto completed = [&](const std::string& words, int at) {
    const std::string out = (folder / "words.txt").string();
    const std::string line = "bash -c 'source " + (folder / "completion.sh").string() + "; COMP_WORDS=(" + words +
                             "); COMP_CWORD=" + std::to_string(at) + "; _kalfem; echo ${COMPREPLY[@]}' >" + out;
    EXPECT_EQ(std::system(line.c_str()), 0);
    return read(out);
  };
  EXPECT_EQ(completed("kalfem upd", 1), "update\n");
  EXPECT_EQ(completed("kalfem run --st", 2), "--strict\n");
  EXPECT_EQ(completed("kalfem inspect --js", 2), "--json\n");
  for (const std::string shell : {"zsh", "fish"}) EXPECT_EQ(run_command("completion " + shell, folder).code, 0);
  EXPECT_EQ(run_command("completion csh", folder).code, 2);
}

TEST(Verbs, ChangeValuesOfTheCase) {
  const ScratchFolder folder("set");
  const std::string file = (folder / "case.yaml").string();
  std::ofstream(file) << simulated;
  const auto run = [&](const std::string& changes) { return run_command("run " + file + " " + changes, folder); };
  const auto changed = run("--set simulate.duration=0.4s --set sensors.a.noise='10 %' --json");
  ASSERT_EQ(changed.code, 0) << changed.errors;
  const auto summary = nlohmann::json::parse(changed.output);  // nothing else is on stdout
  EXPECT_EQ(summary, read_summary(folder / "case.kalfem-out"));
  const std::string resolved = read(folder / "case.kalfem-out" / "case.resolved.yaml");
  EXPECT_NE(resolved.find("duration: 0.4"), std::string::npos) << resolved;
  EXPECT_EQ(run("--quiet").output, "Verdict: none, nothing was compared with measurements\n");
  const auto wrong = run("--set simulate.durations=2s --set oops");
  EXPECT_EQ(wrong.code, 2);
  EXPECT_NE(wrong.errors.find("--set oops: it is no KEY=VALUE"), std::string::npos) << wrong.errors;
  const auto unknown = run("--set simulate.durations=2s");
  EXPECT_EQ(unknown.code, 2);
  EXPECT_NE(unknown.errors.find("did you mean 'duration'"), std::string::npos) << unknown.errors;
  EXPECT_EQ(run("--json --quiet").code, 2);
}

// A long simulation, asked to stop: nothing is left where nothing is finished; the record where that is.
TEST(Verbs, EndCleanlyWhenAskedToStop) {
  const ScratchFolder folder("stopped");
  const std::string file = (folder / "case.yaml").string(), out = (folder / "out").string();
  const auto stopped = [&](const std::string& text, int signal, auto ready) {
    std::ofstream(file) << text;
    const pid_t child = start({command_file(), "run", file, "--out", out});
    while (!ready()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    kill(child, signal);
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  };
  std::string text = simulated;
  text.replace(text.find("0.2 s"), 5, "40000 s");
  EXPECT_EQ(stopped(text, SIGTERM, [] { return std::this_thread::sleep_for(std::chrono::seconds(1)), true; }), 130);
  EXPECT_FALSE(std::filesystem::exists(out));
  const std::string slow =
      "estimate: {substeps: 1, diagnose: false, settle: 0.1 s, unknown: {wheel.w.mass: {initial: 1.4, std: 10 %}}}\n"
      "infer: {method: tempered, samples: 20000}\n";
  const auto checkpoint = folder / "out" / "infer.checkpoint";
  EXPECT_EQ(stopped(simulated + slow, SIGINT, [&] { return std::filesystem::exists(checkpoint); }), 130);
  EXPECT_EQ(read_summary(out)["verdict"]["state"], "unusable");
  EXPECT_TRUE(read_summary(out).contains("estimation"));
  EXPECT_TRUE(std::filesystem::exists(checkpoint));
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
