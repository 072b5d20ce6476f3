// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "base/places.hpp"
#include "command.hpp"

namespace kalfem::test {
namespace {

Outcome run_launched(const std::string& environment) {
  const ScratchFolder folder("launched");
  const std::string line = "env " + environment + " " + command_file() + " schema estimate >" +
                           (folder / "stdout.txt").string() + " 2>" + (folder / "stderr.txt").string();
  const int status = std::system(line.c_str());
  return {WEXITSTATUS(status), read(folder / "stdout.txt"), read(folder / "stderr.txt")};
}

// Under mpirun each rank of a program without MPI would do the whole work, and write the same files.
TEST(Launcher, OfSeveralRanksIsRefusedOnce) {
  for (const auto& [ranks, rank] : {std::pair{"OMPI_COMM_WORLD_SIZE=4", "OMPI_COMM_WORLD_RANK="},
                                    {"PMI_SIZE=4", "PMI_RANK="},
                                    {"SLURM_STEP_NUM_TASKS=4", "SLURM_PROCID="}}) {
    const auto first = run_launched(std::string(ranks) + " " + rank + "0");
    EXPECT_EQ(first.code, 2) << ranks;
    EXPECT_EQ(first.output, "");
    EXPECT_NE(first.errors.find("kalfem was started on 4 ranks"), std::string::npos) << first.errors;
    EXPECT_NE(first.errors.find("cmake --preset mpi"), std::string::npos) << first.errors;
    const auto third = run_launched(std::string(ranks) + " " + rank + "2");
    EXPECT_EQ(third.code, 2) << ranks;
    EXPECT_EQ(third.output + third.errors, "");
  }
}

TEST(Launcher, OfOneRankIsNoOne) {
  for (const std::string ranks : {"OMPI_COMM_WORLD_SIZE=1", "PMI_SIZE=", "SLURM_STEP_NUM_TASKS=1"})
    EXPECT_EQ(run_launched(ranks).code, 0) << ranks;
}

}  // namespace
}  // namespace kalfem::test
