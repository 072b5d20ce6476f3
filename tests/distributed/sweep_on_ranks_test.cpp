// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstdlib>

#include "base/places.hpp"
#include "cli/command.hpp"

namespace kalfem::test {
namespace {

/// Exit code and what was said; the folder gets the files of the sweep.
Outcome sweep(const std::string& launcher, const std::string& arguments, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  const std::string line = launcher + " " + command_file() + " sweep " + arguments + " --out " + folder.string() +
                           " >" + (folder / "stdout.txt").string() + " 2>" + (folder / "stderr.txt").string();
  const int status = std::system(line.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read(folder / "stdout.txt"), read(folder / "stderr.txt")};
}

std::string on(int ranks) { return std::string(KALFEM_MPIRUN) + " -n " + std::to_string(ranks); }

std::string of_the_chain() {
  return example("start/chain/case.yaml") + " --set simulate.duration=2s --set estimate.substeps=4 --seeds 5";
}

TEST(SweepOnRanks, MakesTheBytesOfOneProcess) {
  const ScratchFolder folder("sweep-on-ranks");
  ASSERT_EQ(sweep("", of_the_chain(), folder / "serial").code, 0);
  for (const int ranks : {2, 3}) {
    const auto shared = folder / std::to_string(ranks);
    const auto outcome = sweep(on(ranks), of_the_chain(), shared);
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    for (const char* file : {"runs.jsonl", "sweep.csv"})
      EXPECT_EQ(read(shared / file), read(folder / "serial" / file)) << ranks << " ranks, " << file;
  }
}

TEST(SweepOnRanks, GoesOnWithWhatIsKnown) {
  const ScratchFolder folder("known-on-ranks");
  ASSERT_EQ(sweep("", of_the_chain(), folder / "serial").code, 0);
  const std::string whole = read(folder / "serial" / "runs.jsonl");
  std::filesystem::create_directories(folder / "shared");
  const auto third_line = whole.find('\n', whole.find('\n') + 1) + 1;
  std::ofstream(folder / "shared" / "runs.jsonl") << whole.substr(0, third_line);
  const auto outcome = sweep(on(2), of_the_chain(), folder / "shared");
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_NE(outcome.output.find("1 of 5 runs are known"), std::string::npos) << outcome.output;
  EXPECT_EQ(read(folder / "shared" / "runs.jsonl"), whole);
}

TEST(SweepOnRanks, RefusesACaseOnce) {
  const ScratchFolder folder("refused-on-ranks");
  const auto outcome = sweep(on(3), (folder / "absent.yaml").string(), folder / "out");
  EXPECT_EQ(outcome.code, 2);
  const auto place = outcome.errors.find("absent.yaml");
  EXPECT_NE(place, std::string::npos) << outcome.errors;
  EXPECT_EQ(outcome.errors.find("absent.yaml", place + 1), std::string::npos) << outcome.errors;
}

TEST(SweepOnRanks, EndsWhereItsFolderCannotBeWritten) {
  const ScratchFolder folder("no-folder-on-ranks");
  std::filesystem::create_directories(folder / "out" / "sweep.csv");  // where a file shall stand
  const auto outcome = sweep(on(2), of_the_chain(), folder / "out");
  EXPECT_EQ(outcome.code, 2) << outcome.errors;
  EXPECT_NE(outcome.errors.find("sweep.csv"), std::string::npos) << outcome.errors;
}

TEST(SweepOnRanks, NamesARankWithAnotherSweep) {
  const ScratchFolder folder("other-sweep");
  // The second program of the launcher, which is rank 1, is given another number of seeds.
  const std::string other = command_file() + " sweep " + example("start/chain/case.yaml") + " --seeds 4";
  const auto outcome = sweep(std::string(KALFEM_MPIRUN) + " -n 1 " + other + " : -n 1", of_the_chain(), folder / "out");
  EXPECT_EQ(outcome.code, 2) << outcome.errors;
  EXPECT_NE(outcome.errors.find("rank 1 of 2 has another sweep than rank 0"), std::string::npos) << outcome.errors;
}

}  // namespace
}  // namespace kalfem::test
