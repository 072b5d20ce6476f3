// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstring>

#include "kalfem/base/vector_loops.hpp"

namespace kalfem {

/// Neighbouring points in a vector register, or in several smaller ones.
typedef double EightPoints __attribute__((vector_size(64)));
typedef double FourPoints __attribute__((vector_size(32)));
typedef double TwoPoints __attribute__((vector_size(16)));

template <class Points>
[[gnu::always_inline]] inline void load(const double* from, Points& to) {
  std::memcpy(&to, from, sizeof(Points));
}
template <class Points>
[[gnu::always_inline]] inline void store(const Points& from, double* to) {
  std::memcpy(to, &from, sizeof(Points));
}

/// A block of points of a column.
template <class Points>
struct Block {
  [[gnu::always_inline]] explicit Block(const double* from) { load(from, value); }
  Points value;
};

/// Calls `work.operator()<Points>(first)` for consecutive blocks of 8 points and a rest of 4, 2 and 1, where Points is
/// one of the types above or double.
template <class Work>
[[gnu::always_inline]] inline void in_blocks(std::ptrdiff_t count, const Work& work) {
  std::ptrdiff_t i = 0;
  for (; i + 8 <= count; i += 8) work.template operator()<EightPoints>(i);
  if ((count & 4) != 0) {
    work.template operator()<FourPoints>(i);
    i += 4;
  }
  if ((count & 2) != 0) {
    work.template operator()<TwoPoints>(i);
    i += 2;
  }
  if ((count & 1) != 0) work.template operator()<double>(i);
}

/// The same in registers of the width that the program runs with; the work is marked KALFEM_INLINE.
template <class Work>
void in_widest_blocks(std::ptrdiff_t count, const Work& work) {
  in_widest_registers([&]() KALFEM_INLINE { in_blocks(count, work); });
}

}  // namespace kalfem
