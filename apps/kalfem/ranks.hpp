// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

namespace kalfem::command {

/// What an MPI launcher (mpirun, mpiexec, srun) says of this process in the environment; a single rank without one.
struct LaunchedRank {
  int ranks = 1, rank = 0;
};
LaunchedRank launched_rank();

/// The command among the processes that a launcher started: on rank 0 `command`, which the others serve. Returns its
/// exit code. Throws InvalidInput where there are several ranks and kalfem was built without MPI.
int on_ranks(int argc, char** argv, const std::function<int()>& command);

}  // namespace kalfem::command
