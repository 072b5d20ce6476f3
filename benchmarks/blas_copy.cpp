// SPDX-License-Identifier: Apache-2.0
#include "blas_copy.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>

#include "kalfem/base/text.hpp"
#include "kalfem/linalg/blas.hpp"

// OpenBLAS declares the last in headers that other BLAS libraries do not have; weak, so that any BLAS links.
extern "C" {
void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info);
void dsyrk_(const char* uplo, const char* trans, const int* n, const int* k, const double* alpha, const double* a,
            const int* lda, const double* beta, double* c, const int* ldc);
[[gnu::weak]] char* openblas_get_config();
[[gnu::weak]] void openblas_set_num_threads(int threads);
}

namespace kalfem::benchmarks {

namespace {

std::vector<std::string> kernels_of_this_processor() {
  std::vector<std::string> names;
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl")) names.emplace_back("SkylakeX");
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) names.emplace_back("Haswell");
#endif
  return names;
}

template <class Function>
bool find(void* library, const char* name, Function& function) {
  return (function = reinterpret_cast<Function>(dlsym(library, name))) != nullptr;
}

/// A second copy in a namespace of its own of the library at `path`; the environment variable tells it what to take.
bool load(const char* path, const std::string& kernel, BlasCopy& copy) {
  setenv("OPENBLAS_CORETYPE", kernel.c_str(), 1);
  setenv("OPENBLAS_NUM_THREADS", "1", 1);
  void* const library = dlmopen(LM_ID_NEWLM, path, RTLD_NOW | RTLD_LOCAL);
  char* (*name)() = nullptr;
  if (library == nullptr || !find(library, "openblas_get_corename", name)) return false;
  copy.kernel = name();
  return lower_case(copy.kernel) == lower_case(kernel) && find(library, "dpotrf_", copy.dpotrf) &&
         find(library, "dsyrk_", copy.dsyrk);
}

}  // namespace

const BlasCopy& linked_blas() {
  static const BlasCopy copy{blas_kernels(), dpotrf_, dsyrk_};
  return copy;
}

const std::vector<BlasCopy>& other_blas_kernels() {
  static const std::vector<BlasCopy> copies = [] {
    std::vector<BlasCopy> loaded;
    Dl_info library;
    if (blas_kernels().empty() || dladdr(reinterpret_cast<void*>(dpotrf_), &library) == 0) return loaded;
    for (const auto& kernel : kernels_of_this_processor())
      if (BlasCopy copy; lower_case(kernel) != lower_case(blas_kernels()) && load(library.dli_fname, kernel, copy))
        loaded.push_back(copy);
    return loaded;
  }();
  return copies;
}

std::string blas_name() { return openblas_get_config != nullptr ? openblas_get_config() : "not OpenBLAS"; }

void use_one_blas_thread() {
  if (openblas_set_num_threads != nullptr) openblas_set_num_threads(1);
}

}  // namespace kalfem::benchmarks
