// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/blas.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <mutex>
#include <new>
#include <string_view>

#include <sys/mman.h>

// Declared weak, so that a BLAS library without them links as well.
extern "C" {
[[gnu::weak]] void openblas_set_num_threads(int count);
[[gnu::weak]] int openblas_get_num_threads();
[[gnu::weak]] void omp_set_max_active_levels(int levels);
[[gnu::weak]] int omp_get_max_active_levels();
void dpotrf_(const char* triangle, const int* order, double* matrix, const int* leading, int* failed);
}

namespace kalfem {

void keep_blas_to_one_thread() {
  static std::once_flag done;
  std::call_once(done, [] {
    if (openblas_set_num_threads != nullptr) openblas_set_num_threads(1);
  });
}

OneOpenMpThread::OneOpenMpThread() {
  if (omp_get_max_active_levels == nullptr) return;
  levels_ = omp_get_max_active_levels();
  omp_set_max_active_levels(0);
}

OneOpenMpThread::~OneOpenMpThread() {
  if (omp_set_max_active_levels != nullptr) omp_set_max_active_levels(levels_);
}

void take_blas_buffer() {
  constexpr std::size_t room = 160 << 20;
  void* probe = mmap(nullptr, room, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (probe == MAP_FAILED) throw std::bad_alloc();
  munmap(probe, room);
  const int order = 1;
  double matrix = 1.0;
  int failed = 0;
  dpotrf_("L", &order, &matrix, &order, &failed);
}

int blas_threads() { return openblas_get_num_threads != nullptr ? openblas_get_num_threads() : 0; }

}  // namespace kalfem

// Declared weak, so that a BLAS library without it links as well.
extern "C" {
[[gnu::weak]] char* openblas_get_corename();
}

#include "kalfem/base/text.hpp"

namespace kalfem {

namespace {

/// OpenBLAS's x86-64 kernels without AVX2, the newest of 2012.
constexpr std::array<std::string_view, 15> old_kernels = {
    "katmai",  "coppermine",  "northwood", "prescott", "banias",    "core2",  "penryn", "dunnington",
    "nehalem", "sandybridge", "athlon",    "opteron",  "barcelona", "bobcat", "generic"};

bool processor_has_avx2() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
  return false;
#endif
}

bool processor_has_avx512() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl");
#else
  return false;
#endif
}

}  // namespace

std::string blas_kernels() { return openblas_get_corename != nullptr ? openblas_get_corename() : ""; }

std::optional<std::string> blas_warning(const std::string& kernels, bool has_avx2, bool has_avx512) {
  if (!has_avx2 || std::ranges::find(old_kernels, lower_case(kernels)) == old_kernels.end()) return std::nullopt;
  return "OpenBLAS runs its " + kernels + " kernels, although this processor has " +
         (has_avx512 ? std::string("AVX-512") : std::string("AVX2")) +
         ": large models are solved more slowly than possible; set the environment variable OPENBLAS_CORETYPE=" +
         (has_avx512 ? "SkylakeX" : "Haswell") + " (Zen on AMD processors)";
}

std::optional<std::string> blas_warning() {
  return blas_warning(blas_kernels(), processor_has_avx2(), processor_has_avx512());
}

}  // namespace kalfem
