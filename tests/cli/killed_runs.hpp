// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <thread>

#include "base/places.hpp"
#include "short_case.hpp"
#include "started_command.hpp"

/// Runs that are killed at any moment leave the results of one run, whole: those before or those of the killed one.
namespace kalfem::test {

struct KilledRuns {
  int killed = 0, took_effect = 0;
};

/// Kills so many runs, every other one while it writes its results.
inline KilledRuns kill_runs(int moments) {
  namespace fs = std::filesystem;
  using Clock = std::chrono::steady_clock;
  const ScratchFolder folder("killed-runs");
  const fs::path out = folder / "out";
  const std::array files{write_case(folder, "one.yaml", short_case("A")),
                         write_case(folder, "two.yaml", short_case("B"))};
  const auto run = [&](int i) {
    return std::vector<std::string>{command_file(), "run", files[static_cast<std::size_t>(i % 2)], "--out",
                                    out.string()};
  };
  const auto wait_for = [](pid_t child) {
    int status = 0;
    waitpid(child, &status, 0);
    return status;
  };
  std::array<std::string, 2> identities;
  double duration = 0.0;
  for (int i = 0; i < 4; ++i) {
    const auto begin = Clock::now();
    EXPECT_EQ(wait_for(start(run(i))), 0);
    duration = std::chrono::duration<double>(Clock::now() - begin).count();
    identities[static_cast<std::size_t>(i % 2)] = identity_of(out);
  }
  EXPECT_NE(identities[0], identities[1]);
  std::ofstream(out / "notes.txt") << "mine";
  KilledRuns counts;
  std::string last = identity_of(out);
  for (int i = 0; counts.killed < moments && i < 20 * moments; ++i) {
    const double part = std::fmod(0.6180339887 * i, 1.0);  // evenly, without a pattern
    const double moment = duration * (i % 2 == 0 ? part : 0.6 + 0.4 * part);
    const pid_t child = start(run(i));
    std::this_thread::sleep_for(std::chrono::duration<double>(moment));
    kill(child, SIGKILL);
    const int status = wait_for(child);
    counts.killed += WIFSIGNALED(status) ? 1 : 0;
    // A run takes longer or shorter as the machine is loaded: the moments follow, so that they stay within the run.
    duration *= WIFSIGNALED(status) ? 1.02 : 0.85;
    const std::string found = identity_of(out);
    EXPECT_TRUE(found == last || found == identities[static_cast<std::size_t>(i % 2)])
        << found << " after moment " << i;
    EXPECT_EQ(read(out / "notes.txt"), "mine");
    counts.took_effect += found != last ? 1 : 0;
    last = found;
  }
  // The next run clears up behind all of them.
  EXPECT_EQ(wait_for(start(run(0))), 0);
  EXPECT_EQ(identity_of(out), identities[0]);
  EXPECT_EQ(files_of(out), (std::set<std::string>{"case.identified.yaml", "case.resolved.yaml", "notes.txt",
                                                  "report.html", "results.h5", "summary.json"}));
  return counts;
}

}  // namespace kalfem::test
