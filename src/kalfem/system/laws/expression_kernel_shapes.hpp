// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

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

// Kernels call each other in the order of the instructions, so that each has its own jump to the next one.
// Captureless lambdas become kernels by their number of operands.
template <class Compute>
constexpr TapeKernel unary(Compute) {
  return [](const Instruction* at, double* const* table, std::ptrdiff_t count) {
    for_all(Compute{}, count, column(table, at->out), column(table, at->a));
    at[1].kernel(at + 1, table, count);
  };
}
template <class Compute>
constexpr TapeKernel binary(Compute) {
  return [](const Instruction* at, double* const* table, std::ptrdiff_t count) {
    for_all(Compute{}, count, column(table, at->out), column(table, at->a), column(table, at->b));
    at[1].kernel(at + 1, table, count);
  };
}
template <class Compute>
constexpr TapeKernel ternary(Compute) {
  return [](const Instruction* at, double* const* table, std::ptrdiff_t count) {
    for_all(Compute{}, count, column(table, at->out), column(table, at->a), column(table, at->b), column(table, at->c));
    at[1].kernel(at + 1, table, count);
  };
}
template <class Compute>
constexpr TapeKernel quaternary(Compute) {
  return [](const Instruction* at, double* const* table, std::ptrdiff_t count) {
    for_all(Compute{}, count, column(table, at->out), column(table, at->a), column(table, at->b), column(table, at->c),
            column(table, at->d));
    at[1].kernel(at + 1, table, count);
  };
}

}  // namespace kalfem
