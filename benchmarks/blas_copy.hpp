// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace kalfem::benchmarks {

/// The two routines of the limit, from one copy of the BLAS library in memory.
struct BlasCopy {
  std::string kernel;  ///< OpenBLAS's name of its processor kernels
  void (*dpotrf)(const char* uplo, const int* n, double* a, const int* lda, int* info) = nullptr;
  void (*dsyrk)(const char* uplo, const char* trans, const int* n, const int* k, const double* alpha, const double* a,
                const int* lda, const double* beta, double* c, const int* ldc) = nullptr;
};

/// The library that the program is linked to.
const BlasCopy& linked_blas();

/// Further copies of OpenBLAS with its other kernels for this processor. The library chooses kernels once, when it is
/// loaded, and takes those of 2004 where it does not know a newer processor. Empty where the library is another one or
/// cannot be loaded twice.
const std::vector<BlasCopy>& other_blas_kernels();

/// Name of the library with its version.
std::string blas_name();
/// One thread in all copies; to be called before any is used.
void use_one_blas_thread();

}  // namespace kalfem::benchmarks
