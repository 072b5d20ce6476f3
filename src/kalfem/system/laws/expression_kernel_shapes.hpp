// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "kalfem/base/vector_loops.hpp"
#include "kalfem/system/laws/expression_kernels.hpp"
#include "kalfem/system/laws/expression_lanes.hpp"

namespace kalfem {

[[gnu::always_inline]] inline double* column(double* const* table, Place place) {
  return table[place.base] + place.offset;
}

/// out = compute(operands), block by block; compute writes its first argument.
template <class Compute, class... Columns>
[[gnu::always_inline]] inline void for_all(Compute compute, std::ptrdiff_t count, double* out, const Columns*... in) {
  in_blocks(
      count, [&]<class Points>(std::ptrdiff_t i) __attribute__((always_inline)) {
        Points result;
        compute(result, Block<Points>(in + i).value...);
        store(result, out + i);
      });
}

/// The kernel that does `work` on the columns of an instruction, in registers of the width that the program runs with.
/// Kernels call each other in the order of the instructions, so that each has its own jump to the next one.
template <class Work>
TapeKernel kernel_for(Work) {
#if defined(KALFEM_WIDE_LOOPS)
  constexpr TapeKernel wide = [](const Instruction* at, double* const* table, std::ptrdiff_t count) KALFEM_AVX2 {
    Work{}(*at, table, count);
    at[1].kernel(at + 1, table, count);
  };
  if (loops_are_wide()) return wide;
#endif
  return [](const Instruction* at, double* const* table, std::ptrdiff_t count) {
    Work{}(*at, table, count);
    at[1].kernel(at + 1, table, count);
  };
}

// Captureless lambdas become kernels by their number of operands.
template <class Compute>
TapeKernel unary(Compute) {
  return kernel_for([](const Instruction& at, double* const* table, std::ptrdiff_t count)
                        KALFEM_INLINE { for_all(Compute{}, count, column(table, at.out), column(table, at.a)); });
}
template <class Compute>
TapeKernel binary(Compute) {
  return kernel_for([](const Instruction& at, double* const* table, std::ptrdiff_t count) KALFEM_INLINE {
    for_all(Compute{}, count, column(table, at.out), column(table, at.a), column(table, at.b));
  });
}
template <class Compute>
TapeKernel ternary(Compute) {
  return kernel_for([](const Instruction& at, double* const* table, std::ptrdiff_t count) KALFEM_INLINE {
    for_all(Compute{}, count, column(table, at.out), column(table, at.a), column(table, at.b), column(table, at.c));
  });
}
template <class Compute>
TapeKernel quaternary(Compute) {
  return kernel_for([](const Instruction& at, double* const* table, std::ptrdiff_t count) KALFEM_INLINE {
    for_all(Compute{}, count, column(table, at.out), column(table, at.a), column(table, at.b), column(table, at.c),
            column(table, at.d));
  });
}

}  // namespace kalfem
