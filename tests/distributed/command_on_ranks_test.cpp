// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <thread>

#include "base/places.hpp"
#include "cli/command.hpp"
#include "cli/started_command.hpp"

namespace kalfem::test {
namespace {

/// The command with `launcher` before it; every matrix of the small vehicle is distributed where that is mpirun.
std::string line_of(const std::string& launcher, const std::string& arguments, const std::filesystem::path& folder) {
  return "env MESH=small.msh DURATION=3 KALFEM_DISTRIBUTED_ROWS=100 " + launcher + " " + command_file() + " " +
         arguments + " >" + (folder / "stdout.txt").string() + " 2>" + (folder / "stderr.txt").string();
}

std::string on(int ranks) { return std::string(KALFEM_MPIRUN) + " -n " + std::to_string(ranks); }

Outcome run(const std::string& launcher, const std::string& arguments, const std::filesystem::path& folder) {
  const int status = std::system(line_of(launcher, arguments, folder).c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read(folder / "stdout.txt"), read(folder / "stderr.txt")};
}

nlohmann::json summary_of(const std::string& launcher, const std::string& verb, const std::string& case_file) {
  const ScratchFolder folder("on-ranks");
  const auto outcome = run(launcher, verb + " " + example(case_file) + " --out " + (folder / "out").string(), folder);
  EXPECT_EQ(outcome.code, 0) << launcher << outcome.errors;
  EXPECT_EQ(outcome.errors, "") << launcher;
  return outcome.code == 0 ? read_summary(folder / "out") : nlohmann::json();
}

nlohmann::json frequencies_of(const nlohmann::json& summary) {
  return summary.at("model").at("substructures").at("frame").at("frequencies_hz");
}

TEST(CommandOnRanks, FindsTheSameModes) {
  const auto serial = summary_of("", "modes", "vehicle/vehicle.yaml");
  const auto expected = frequencies_of(serial);
  ASSERT_GT(expected.size(), 10U);
  for (const int ranks : {2, 4}) {
    const auto found = frequencies_of(summary_of(on(ranks), "modes", "vehicle/vehicle.yaml"));
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i)
      EXPECT_NEAR(found[i].get<double>(), expected[i].get<double>(), 1e-9 * expected[i].get<double>()) << ranks;
  }
}

TEST(CommandOnRanks, IdentifiesTheSameParameters) {
  const auto serial = summary_of("", "run", "vehicle/stiffness.yaml");
  const auto distributed = summary_of(on(2), "run", "vehicle/stiffness.yaml");
  ASSERT_FALSE(serial.at("parameters").empty());
  for (const auto& [name, parameter] : serial.at("parameters").items()) {
    const double estimate = parameter.at("estimate").get<double>();
    EXPECT_NEAR(distributed.at("parameters").at(name).at("estimate").get<double>(), estimate,
                1e-6 * std::abs(estimate));
  }
}

TEST(CommandOnRanks, SaysWhereTheOtherRanksHadNothingToDo) {
  const ScratchFolder folder("idle-ranks");
  std::ofstream(folder / "case.yaml") << "kalfem: 1\nsubstructures: {wheel: {masses: {w: 1.5 kg}, springs: [{from: "
                                         "ground, to: w, stiffness: 20 kN/m}]}}\n";
  const auto outcome = run(on(4), "modes " + (folder / "case.yaml").string(), folder);
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_NE(outcome.errors.find("4 ranks were started, and rank 0 did everything"), std::string::npos)
      << outcome.errors;
}

TEST(CommandOnRanks, RefusesANumberOfRowsThatIsNone) {
  const ScratchFolder folder("wrong-rows");
  const auto outcome = run(on(2) + " env KALFEM_DISTRIBUTED_ROWS=many", "schema", folder);
  EXPECT_EQ(outcome.code, 2);
  const std::string said = "KALFEM_DISTRIBUTED_ROWS=many: ";
  const auto place = outcome.errors.find(said);
  EXPECT_NE(place, std::string::npos) << outcome.errors;
  EXPECT_EQ(outcome.errors.find(said, place + 1), std::string::npos) << "each rank says so";
}

TEST(CommandOnRanks, KeepsItsExitCode) {
  const ScratchFolder folder("exit-code");
  const auto outcome = run(on(2), "run " + (folder / "absent.yaml").string(), folder);
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.errors.find("absent.yaml"), std::string::npos) << outcome.errors;
}

/// The processes that a process has started.
std::vector<pid_t> children_of(pid_t process) {
  std::ifstream file("/proc/" + std::to_string(process) + "/task/" + std::to_string(process) + "/children");
  return {std::istream_iterator<pid_t>(file), {}};
}

TEST(CommandOnRanks, EndsWhereAWorkerDies) {
  const ScratchFolder folder("dead-worker");
  const std::string line = line_of(
      on(2),
      "run " + example("vehicle/vehicle.yaml") + " --set simulate.duration=300s --out " + (folder / "out").string(),
      folder);
  const pid_t launcher = start({"/bin/sh", "-c", "exec " + line});
  while (children_of(launcher).size() < 2) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  std::this_thread::sleep_for(std::chrono::seconds(2));
  const auto ranks = children_of(launcher);
  ASSERT_EQ(ranks.size(), 2U) << "the run is over already: " << read(folder / "stderr.txt");
  kill(ranks[1], SIGKILL);
  int status = 0;
  waitpid(launcher, &status, 0);  // the time limit of the test would tell of a rank that waits for the dead one
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_NE(WEXITSTATUS(status), 0);
  EXPECT_NE(read(folder / "stderr.txt").find("exited on signal 9"), std::string::npos) << read(folder / "stderr.txt");
}

}  // namespace
}  // namespace kalfem::test
