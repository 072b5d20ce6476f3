// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace kalfem {

// The hot loops are compiled once for each width of vector registers; which of them a program runs is decided when it
// starts. So a package that runs on every processor is not slower on those of today.

/// Vector registers of 16, 32 and 64 bytes, the latter two with fused multiply-add.
enum class VectorWidth { baseline, avx2, avx512 };

inline constexpr std::array vector_width_names = {"baseline", "avx2", "avx512"};

/// The widest that this processor has, or the one that the environment variable KALFEM_CPU names: "baseline", "avx2",
/// "avx512". Throws InvalidInput where it names another, or one that this processor does not have.
VectorWidth vector_width();

/// The width of that name; nothing where there is none, or this processor does not have it.
std::optional<VectorWidth> vector_width(std::string_view name);

#if defined(__x86_64__) && !defined(__AVX2__)
#define KALFEM_WIDE_LOOPS
#endif

/// KALFEM_INDEPENDENT before a loop: no iteration writes what another one reads or writes, so the compiler may run them
/// side by side.
#if defined(__clang__)
#define KALFEM_INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#elif defined(__GNUC__)
#define KALFEM_INDEPENDENT _Pragma("GCC ivdep")
#else
#define KALFEM_INDEPENDENT
#endif

/// Before the body of a lambda that in_widest_registers() calls, and of all that it calls for each point.
#define KALFEM_INLINE __attribute__((always_inline))

#if defined(KALFEM_WIDE_LOOPS)
/// Before the body of a function that is compiled for processors with AVX2. What is not inlined into it stays as it is.
#define KALFEM_AVX2 __attribute__((target("avx2,fma,bmi,bmi2")))

/// Whether functions compiled for AVX2 are to be called.
inline bool loops_are_wide() {
  static const bool wide = vector_width() != VectorWidth::baseline;
  return wide;
}

template <class Loop>
KALFEM_AVX2 auto in_avx2_registers(const Loop& loop) {
  return loop();
}
#endif

/// Calls the loop, a lambda marked KALFEM_INLINE, compiled for registers of 32 bytes where the processor has them: of
/// loops that wait for memory and for divisions, wider ones gain nothing.
template <class Loop>
auto in_widest_registers(const Loop& loop) {
#if defined(KALFEM_WIDE_LOOPS)
  if (loops_are_wide()) return in_avx2_registers(loop);
#endif
  return loop();
}

}  // namespace kalfem
