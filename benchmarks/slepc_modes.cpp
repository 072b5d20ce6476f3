// SPDX-License-Identifier: Apache-2.0
// Lowest modes of K phi = lambda M phi by SLEPc's Krylov-Schur method, shifted and inverted by MUMPS: the yardstick of
// `mpirun -n N kalfem modes`. Usage:
//   petsc_matrices barrel.bdf barrel && mpirun -n 2 slepc_modes barrel.K barrel.M [MODES [SHIFT_HZ]]
// The shift lies below zero, as K may be singular; SLEPc's and PETSc's own options (-eps_view, -mat_mumps_icntl_7 5)
// count too.
#include <slepceps.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <vector>

#include "timing.hpp"

namespace {

Mat load(const char* path) {
  PetscViewer viewer = nullptr;
  Mat matrix = nullptr;
  PetscCallAbort(PETSC_COMM_WORLD, PetscViewerBinaryOpen(PETSC_COMM_WORLD, path, FILE_MODE_READ, &viewer));
  PetscCallAbort(PETSC_COMM_WORLD, MatCreate(PETSC_COMM_WORLD, &matrix));
  PetscCallAbort(PETSC_COMM_WORLD, MatLoad(matrix, viewer));
  PetscCallAbort(PETSC_COMM_WORLD, PetscViewerDestroy(&viewer));
  PetscCallAbort(PETSC_COMM_WORLD, MatSetOption(matrix, MAT_SYMMETRIC, PETSC_TRUE));
  return matrix;
}

EPS solver_of(Mat stiffness, Mat mass, PetscInt modes, double shift) {
  EPS eps = nullptr;
  ST transformation = nullptr;
  KSP linear = nullptr;
  PC factor = nullptr;
  PetscCallAbort(PETSC_COMM_WORLD, EPSCreate(PETSC_COMM_WORLD, &eps));
  PetscCallAbort(PETSC_COMM_WORLD, EPSSetOperators(eps, stiffness, mass));
  PetscCallAbort(PETSC_COMM_WORLD, EPSSetProblemType(eps, EPS_GHEP));
  PetscCallAbort(PETSC_COMM_WORLD, EPSSetType(eps, EPSKRYLOVSCHUR));
  PetscCallAbort(PETSC_COMM_WORLD, EPSSetDimensions(eps, modes, PETSC_DEFAULT, PETSC_DEFAULT));
  PetscCallAbort(PETSC_COMM_WORLD, EPSSetTolerances(eps, 1e-10, 1000));
  PetscCallAbort(PETSC_COMM_WORLD, EPSSetWhichEigenpairs(eps, EPS_TARGET_MAGNITUDE));
  PetscCallAbort(PETSC_COMM_WORLD, EPSSetTarget(eps, -shift));
  PetscCallAbort(PETSC_COMM_WORLD, EPSGetST(eps, &transformation));
  PetscCallAbort(PETSC_COMM_WORLD, STSetType(transformation, STSINVERT));
  PetscCallAbort(PETSC_COMM_WORLD, STGetKSP(transformation, &linear));
  PetscCallAbort(PETSC_COMM_WORLD, KSPSetType(linear, KSPPREONLY));
  PetscCallAbort(PETSC_COMM_WORLD, KSPGetPC(linear, &factor));
  PetscCallAbort(PETSC_COMM_WORLD, PCSetType(factor, PCCHOLESKY));
  PetscCallAbort(PETSC_COMM_WORLD, PCFactorSetMatSolverType(factor, MATSOLVERMUMPS));
  PetscCallAbort(PETSC_COMM_WORLD, EPSSetFromOptions(eps));
  return eps;
}

}  // namespace

int main(int argc, char** argv) {
  using kalfem::benchmarks::seconds;
  if (argc < 3) {
    std::fprintf(stderr, "usage: slepc_modes K M [MODES [SHIFT_HZ]]\n");
    return 2;
  }
  const PetscInt modes = argc > 3 ? std::atoi(argv[3]) : 26;
  const double shift = std::pow(2.0 * std::numbers::pi * (argc > 4 ? std::atof(argv[4]) : 10.0), 2);
  if (SlepcInitialize(&argc, &argv, nullptr, nullptr) != 0) return 1;
  int rank = 0, ranks = 1;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);

  Mat stiffness = nullptr, mass = nullptr;
  EPS eps = nullptr;
  const double loading = seconds([&] { stiffness = load(argv[1]), mass = load(argv[2]); });
  const double solving = seconds([&] {
    eps = solver_of(stiffness, mass, modes, shift);
    PetscCallAbort(PETSC_COMM_WORLD, EPSSolve(eps));
  });

  PetscInt found = 0;
  PetscCallAbort(PETSC_COMM_WORLD, EPSGetConverged(eps, &found));
  std::vector<double> frequencies;
  for (PetscInt i = 0; i < std::min(found, modes); ++i) {
    PetscScalar value = 0.0;
    PetscCallAbort(PETSC_COMM_WORLD, EPSGetEigenvalue(eps, i, &value, nullptr));
    frequencies.push_back(std::sqrt(std::max(PetscRealPart(value), 0.0)) / (2.0 * std::numbers::pi));
  }
  const double peak = kalfem::benchmarks::memory_megabytes("VmHWM");
  std::vector<double> peaks(static_cast<std::size_t>(ranks));
  MPI_Gather(&peak, 1, MPI_DOUBLE, peaks.data(), 1, MPI_DOUBLE, 0, PETSC_COMM_WORLD);
  if (rank == 0) {
    std::printf("%d ranks: loading %.2f s, modes %.2f s, %d converged\n", ranks, loading, solving, int(found));
    for (int i = 0; i < ranks; ++i) std::printf("peak of rank %d %.0f MB\n", i, peaks[static_cast<std::size_t>(i)]);
    for (const double frequency : frequencies) std::printf("%.9g Hz\n", frequency);
  }
  PetscCallAbort(PETSC_COMM_WORLD, EPSDestroy(&eps));
  PetscCallAbort(PETSC_COMM_WORLD, MatDestroy(&stiffness));
  PetscCallAbort(PETSC_COMM_WORLD, MatDestroy(&mass));
  SlepcFinalize();
  return 0;
}
