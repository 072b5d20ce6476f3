// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>
#include <utility>

#include "ranks.hpp"

namespace kalfem::command {

// Open MPI, the launchers of MPICH and Intel MPI, and Slurm.
LaunchedRank launched_rank() {
  const auto number = [](const char* variable) {
    const char* value = std::getenv(variable);
    return value != nullptr ? std::atoi(value) : 0;
  };
  for (const auto& [ranks, rank] : {std::pair{"OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK"},
                                    {"PMI_SIZE", "PMI_RANK"},
                                    {"SLURM_STEP_NUM_TASKS", "SLURM_PROCID"}})
    if (number(ranks) > 1) return {number(ranks), number(rank)};
  return {};
}

}  // namespace kalfem::command
