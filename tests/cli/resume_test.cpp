// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <thread>

#include "base/places.hpp"
#include "short_case.hpp"
#include "started_command.hpp"

namespace kalfem::test {
namespace {

namespace fs = std::filesystem;

/// A chain whose simulation takes seconds, as its step is small, and whose estimation takes seconds too.
std::string long_case() {
  std::string text = short_case("long");
  text.replace(text.find("tolerance: 1e-2"), 15, "substeps: 400");
  text.replace(text.find("duration: 0.5 s"), 15, "duration: 8 s");
  text.replace(text.find("settle: 0.1 s"), 13, "settle: 0.1 s, substeps: 100, diagnose: false");
  return text;
}

class Resume : public testing::Test {
protected:
  /// Kills a run of the case as soon as the file is there.
  void kill_when_there(const std::string& name, const std::string& verb = "run") {
    const pid_t child = start({command_file(), verb, file_, "--out", out_.string(), "--set", "title=changed"});
    while (!fs::exists(out_ / name)) {
      ASSERT_EQ(waitpid(child, nullptr, WNOHANG), 0) << "it ended before it could be killed";
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    kill(child, SIGKILL);
    int status = 0;
    waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status)) << "it ended before it could be killed";
  }
  [[nodiscard]] Outcome resume() const { return run_command("run --resume " + out_.string(), folder_); }

  ScratchFolder folder_{"resume"};
  fs::path out_ = folder_ / "out";
  std::string file_ = write_case(folder_, "case.yaml", long_case());
};

// The identity holds every number of the summary; the series are compared by themselves.
TEST_F(Resume, AKilledRunEndsWithTheSameBits) {
  const fs::path whole = folder_ / "whole";
  ASSERT_EQ(run_command("run " + file_ + " --set title=changed --out " + whole.string(), folder_).code, 0);
  kill_when_there("simulation.checkpoint");
  const auto outcome = resume();
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_EQ(identity_of(out_), identity_of(whole));
  const auto one = Hdf5File::open((whole / "results.h5").string()),
             other = Hdf5File::open((out_ / "results.h5").string());
  ASSERT_EQ(one.datasets(), other.datasets());
  for (const auto& name : one.datasets())
    EXPECT_TRUE((one.read(name).array() == other.read(name).array()).all()) << name;
  EXPECT_EQ(files_of(out_), files_of(whole));
  // Taken from the file, the simulation took no time.
  EXPECT_LT(read_summary(out_)["timing"]["simulate_s"].get<double>(),
            0.5 * read_summary(whole)["timing"]["simulate_s"].get<double>());
  EXPECT_EQ(resume().code, 2);  // it has ended
}

TEST_F(Resume, ADamagedSimulationIsMadeAnew) {
  kill_when_there("simulation.checkpoint");
  const std::string kept = read(out_ / "simulation.checkpoint");
  ASSERT_GT(kept.size(), 10000U);
  std::string damaged = kept;
  damaged[damaged.size() / 2] ^= 1;
  std::ofstream(out_ / "simulation.checkpoint", std::ios::binary) << damaged.substr(0, damaged.size() - 5);
  const auto outcome = resume();
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_GT(read_summary(out_)["timing"]["simulate_s"].get<double>(), 0.5);
}

TEST_F(Resume, RefusesACaseThatHasChanged) {
  kill_when_there("run.resume.json", "estimate");
  std::string text = long_case();
  text.replace(text.find("stiffness: 20 kN/m"), 18, "stiffness: 21 kN/m");
  write_case(folder_, "case.yaml", text);
  const auto outcome = resume();
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.errors.find("the case has changed since the run that is to be resumed"), std::string::npos)
      << outcome.errors;
}

TEST_F(Resume, RefusesAFolderWithoutAnInterruptedRun) {
  const auto nowhere = resume();
  EXPECT_EQ(nowhere.code, 2);
  EXPECT_NE(nowhere.errors.find("it holds no interrupted run"), std::string::npos) << nowhere.errors;
  fs::create_directories(out_);
  std::ofstream(out_ / "run.resume.json") << "{\"kalfem\": ";
  EXPECT_NE(resume().errors.find("it is damaged"), std::string::npos);
  EXPECT_EQ(run_command("run", folder_).code, 2);
  EXPECT_EQ(run_command("run " + file_ + " --resume " + out_.string(), folder_).code, 2);
}

}  // namespace
}  // namespace kalfem::test
