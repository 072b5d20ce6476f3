// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "kalfem/report/finished/sweep.hpp"

namespace kalfem::command {

/// The sweep that every rank has made for itself. Where one of them could not, or has another one, rank 0 throws
/// what its own `make` threw, or InvalidInput, and the others get nothing.
std::unique_ptr<CaseSweep> sweep_of_all_ranks(const std::function<std::unique_ptr<CaseSweep>()>& make);

/// Whether this process makes runs for rank 0 of an MPI launcher.
bool works_for_rank_0();

/// A worker: makes the runs that rank 0 asks for, until there are no more.
void make_runs_for_rank_0(CaseSweep& sweep);

/// Rank 0: CaseSweep::run() with the runs shared by all ranks, one at a time each; a single rank uses its threads.
/// Where a rank dies, the launcher ends all; what was made stays in the folder of the sweep, and the same command goes
/// on.
std::vector<SweepRun> run_on_ranks(CaseSweep& sweep, const SweepOptions& options);

}  // namespace kalfem::command
