// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

namespace kalfem {

/// Lets BLAS and LAPACK work with one thread from now on, in the whole process. Products that several threads share are
/// summed in other orders: with one thread results are the same to the last bit whatever the number of cores and
/// OPENBLAS_NUM_THREADS. Threads of ours that solve side by side do not wait for each other's BLAS threads either.
///
/// The first call of a process sets it, later ones do nothing: a program that links kalfem and wants BLAS threads of
/// its own may set them again after its first factorisation. Libraries other than OpenBLAS are left as they are.
void keep_blas_to_one_thread();

/// Lets BLAS take the buffer of this thread now. OpenBLAS maps 128 MB at the first product of a thread, and where
/// `ulimit -v` leaves no room it tries again for ever. Throws std::bad_alloc where there is none now.
void take_blas_buffer();

/// Threads that BLAS works with; 0 where the library is not OpenBLAS.
int blas_threads();

/// A sentence where the BLAS library runs kernels for an old processor although this one has wider vector units;
/// nothing otherwise, and where the library is not OpenBLAS.
std::optional<std::string> blas_warning();

/// The same decision from the name of the kernels ("Prescott") and what the processor can do.
std::optional<std::string> blas_warning(const std::string& kernels, bool has_avx2, bool has_avx512);

/// Name of the kernels that OpenBLAS chose; empty where the library is another one.
std::string blas_kernels();

/// While it lives, parallel regions of OpenMP that begin in this thread have one thread. CHOLMOD asks for four in its
/// factorisation, which on fewer processors spend their time waiting for each other.
class OneOpenMpThread {
public:
  OneOpenMpThread();
  ~OneOpenMpThread();
  OneOpenMpThread(const OneOpenMpThread&) = delete;
  OneOpenMpThread& operator=(const OneOpenMpThread&) = delete;

private:
  int levels_ = 0;  ///< of nested regions with several threads that were allowed before
};

}  // namespace kalfem
