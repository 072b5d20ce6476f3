// SPDX-License-Identifier: Apache-2.0
#include "kalfem/distributed/mumps_instance.hpp"

#include "kalfem/linalg/blas.hpp"

namespace kalfem::distributed {

namespace {

constexpr int initialise = -1, terminate = -2;
constexpr int symmetric_general = 2;  ///< positive definite is what must be found out

}  // namespace

MumpsInstance::MumpsInstance(MPI_Comm ranks) {
  keep_blas_to_one_thread();
  state_.sym = symmetric_general;
  state_.par = 1;  // rank 0 factors as well
  state_.comm_fortran = static_cast<MUMPS_INT>(MPI_Comm_c2f(ranks));
  state_.job = initialise;
  dmumps_c(&state_);
  for (const int output : {0, 1, 2, 3}) state_.icntl[output] = 0;  // it writes nothing
}

MumpsInstance::~MumpsInstance() {
  state_.job = terminate;
  dmumps_c(&state_);
}

void MumpsInstance::run(MumpsJob job) {
  state_.job = static_cast<MUMPS_INT>(job);
  dmumps_c(&state_);
}

}  // namespace kalfem::distributed
