// SPDX-License-Identifier: Apache-2.0
#include "kalfem/base/vector_loops.hpp"

#include <cstdlib>
#include <string>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

bool has(VectorWidth width) {
#if defined(__x86_64__)
  const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
                    __builtin_cpu_supports("bmi2");
  const bool avx512 = avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512cd") &&
                      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
                      __builtin_cpu_supports("avx512vl");
  return width == VectorWidth::baseline || (width == VectorWidth::avx2 ? avx2 : avx512);
#else
  return width == VectorWidth::baseline;
#endif
}

VectorWidth chosen() {
  const char* wanted = std::getenv("KALFEM_CPU");
  if (wanted == nullptr || *wanted == '\0')
    return has(VectorWidth::avx512) ? VectorWidth::avx512
           : has(VectorWidth::avx2) ? VectorWidth::avx2
                                    : VectorWidth::baseline;
  if (const auto width = vector_width(std::string_view(wanted))) return *width;
  std::string names;
  for (const char* name : vector_width_names)
    if (vector_width(std::string_view(name))) names += (names.empty() ? "" : ", ") + std::string(name);
  throw InvalidInput("the environment variable KALFEM_CPU is '" + std::string(wanted) + "'",
                     "it names the filter's kernels, and this processor runs " + names,
                     "give one of these, or unset it");
}

}  // namespace

std::optional<VectorWidth> vector_width(std::string_view name) {
  for (std::size_t i = 0; i < vector_width_names.size(); ++i)
    if (const auto width = static_cast<VectorWidth>(i); name == vector_width_names[i] && has(width)) return width;
  return std::nullopt;
}

VectorWidth vector_width() {
  static const VectorWidth width = chosen();
  return width;
}

}  // namespace kalfem
