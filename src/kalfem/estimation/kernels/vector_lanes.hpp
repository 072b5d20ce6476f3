// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace kalfem {

/// Eight consecutive doubles. The compiler maps them to the registers that the processor has.
typedef double Lanes __attribute__((vector_size(64)));

constexpr int lane_count = 8;

/// The least multiple of eight that is not below n.
constexpr std::ptrdiff_t whole_lanes(std::ptrdiff_t n) { return (n + lane_count - 1) / lane_count * lane_count; }

[[gnu::always_inline]] inline Lanes load(const double* from) { return *reinterpret_cast<const Lanes*>(from); }
[[gnu::always_inline]] inline void store(double* to, const Lanes& lanes) { *reinterpret_cast<Lanes*>(to) = lanes; }
[[gnu::always_inline]] inline Lanes swap_neighbours(const Lanes& v) {
  return __builtin_shufflevector(v, v, 1, 0, 3, 2, 5, 4, 7, 6);
}

/// The transpose of 8 x 8 doubles, columns in, columns out.
[[gnu::always_inline]] inline void transpose(const Lanes (&in)[8], Lanes (&out)[8]) {
  Lanes pairs[8], quads[8];
#pragma GCC unroll 4
  for (int i = 0; i < 8; i += 2) {
    pairs[i] = __builtin_shufflevector(in[i], in[i + 1], 0, 8, 2, 10, 4, 12, 6, 14);
    pairs[i + 1] = __builtin_shufflevector(in[i], in[i + 1], 1, 9, 3, 11, 5, 13, 7, 15);
  }
#pragma GCC unroll 4
  for (int i = 0; i < 4; ++i) {
    const int from = i < 2 ? i : i + 2;  // 0, 1, 4, 5 with the one two behind
    quads[from] = __builtin_shufflevector(pairs[from], pairs[from + 2], 0, 1, 8, 9, 4, 5, 12, 13);
    quads[from + 2] = __builtin_shufflevector(pairs[from], pairs[from + 2], 2, 3, 10, 11, 6, 7, 14, 15);
  }
#pragma GCC unroll 4
  for (int i = 0; i < 4; ++i) {
    out[i] = __builtin_shufflevector(quads[i], quads[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
    out[i + 4] = __builtin_shufflevector(quads[i], quads[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
  }
}

}  // namespace kalfem
