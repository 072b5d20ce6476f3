// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <dmumps_c.h>
#include <mpi.h>

namespace kalfem::distributed {

/// The jobs of MUMPS that are used here.
enum class MumpsJob : int { analyse = 1, factorize = 2, solve = 3 };

/// One rank's part of a factor that MUMPS [ADKL01] distributes. Making it, run() and its end concern all ranks at once.
class MumpsInstance {
public:
  explicit MumpsInstance(MPI_Comm ranks);
  ~MumpsInstance();
  MumpsInstance(const MumpsInstance&) = delete;
  MumpsInstance& operator=(const MumpsInstance&) = delete;

  void run(MumpsJob job);

  /// Read on rank 0 before a job. Entries of `icntl`, `infog` ... are numbered from 1 in MUMPS' manual.
  DMUMPS_STRUC_C& state() { return state_; }
  [[nodiscard]] const DMUMPS_STRUC_C& state() const { return state_; }

private:
  DMUMPS_STRUC_C state_{};
};

}  // namespace kalfem::distributed
