// SPDX-License-Identifier: Apache-2.0
#include "kalfem/base/invalid_input.hpp"
#include "ranks.hpp"
#include "sweep_on_ranks.hpp"
#include "verbs.hpp"

namespace kalfem::command {

int on_ranks(int, char**, const std::function<int()>& command) {
  const auto [ranks, rank] = launched_rank();
  if (ranks == 1) return command();
  if (rank > 0) return mend_the_input;  // rank 0 says why
  throw InvalidInput("kalfem was started on " + std::to_string(ranks) + " ranks",
                     "it was built without MPI, so each of them would do the whole work and write the same files",
                     "build it with -DKALFEM_MPI=ON (cmake --preset mpi), or start it without mpirun");
}

std::unique_ptr<CaseSweep> sweep_of_all_ranks(const std::function<std::unique_ptr<CaseSweep>()>& make) {
  return make();
}

bool works_for_rank_0() { return false; }

void make_runs_for_rank_0(CaseSweep&) {}

std::vector<SweepRun> run_on_ranks(CaseSweep& sweep, const SweepOptions& options) { return sweep.run(options); }

}  // namespace kalfem::command
