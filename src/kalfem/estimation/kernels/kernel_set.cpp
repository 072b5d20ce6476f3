// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/kernels/kernel_set.hpp"

#include <Eigen/Core>
#include <array>
#include <cstdlib>
#include <string>
#include <string_view>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

namespace baseline {
extern const KernelSet set;
}
#if defined(KALFEM_WIDE_KERNELS)
namespace avx2 {
extern const KernelSet set;
}
namespace avx512 {
extern const KernelSet set;
}
#endif

namespace {

/// From the narrowest to the widest, with whether this processor has what it needs.
struct AvailableSet {
  const KernelSet* set;
  bool runs_here;
};

#if defined(KALFEM_WIDE_KERNELS)
bool has_avx2() {
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
         __builtin_cpu_supports("bmi2");
}
bool has_avx512() {
  return has_avx2() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512cd") &&
         __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
}
const auto& all_sets() {
  static const std::array sets = {AvailableSet{&baseline::set, true}, AvailableSet{&avx2::set, has_avx2()},
                                  AvailableSet{&avx512::set, has_avx512()}};
  return sets;
}
#else
const auto& all_sets() {
  static const std::array sets = {AvailableSet{&baseline::set, true}};
  return sets;
}
#endif

const KernelSet& chosen() {
  const char* wanted = std::getenv("KALFEM_CPU");
  if (wanted != nullptr && *wanted != '\0') {
    if (const KernelSet* set = kernel_set(wanted)) return *set;
    std::string names;
    for (const auto& [set, runs_here] : all_sets())
      if (runs_here) names += (names.empty() ? "" : ", ") + std::string(set->name);
    throw InvalidInput("the environment variable KALFEM_CPU is '" + std::string(wanted) + "'",
                       "it names the filter's kernels, and this processor runs " + names,
                       "give one of these, or unset it");
  }
  const KernelSet* widest = nullptr;
  for (const auto& [set, runs_here] : all_sets())
    if (runs_here) widest = set;
  return *widest;
}

}  // namespace

const KernelSet* kernel_set(const char* name) {
  for (const auto& [set, runs_here] : all_sets())
    if (runs_here && std::string_view(name) == set->name) return set;
  return nullptr;
}

const KernelSet& kernels() {
  static const KernelSet& set = chosen();
  return set;
}

double* kernel_storage(int which, std::ptrdiff_t size) {
  thread_local std::array<Eigen::VectorXd, 2> kept;
  auto& storage = kept[static_cast<std::size_t>(which)];
  if (storage.size() < size) storage.resize(size);
  return storage.data();
}

}  // namespace kalfem
