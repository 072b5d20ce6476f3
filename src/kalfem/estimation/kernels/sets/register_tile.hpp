// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/estimation/kernels/kernel_set.hpp"

namespace kalfem::KALFEM_KERNELS {

// Products of small tiles whose sums stay in vector registers, written for any vector width. Matrices are stored by
// columns; a `stride` is the distance between columns.

using Index = std::ptrdiff_t;

#if defined(__AVX512F__)
constexpr int lane_size = 8;        ///< numbers in a vector register
constexpr int register_count = 32;  ///< vector registers
#elif defined(__AVX__)
constexpr int lane_size = 4;
constexpr int register_count = 16;
#else
constexpr int lane_size = 2;
constexpr int register_count = 16;
#endif

constexpr Index least(Index a, Index b) { return a < b ? a : b; }
constexpr Index most(Index a, Index b) { return a < b ? b : a; }

/// The largest tile whose sums stay in registers beside a column of the left factor.
constexpr int tile_height = (register_count == 32 ? 3 : 2) * lane_size;
constexpr int tile_width = register_count == 32 ? 8 : 6;

template <int Size>
struct Lane {
  typedef double type __attribute__((vector_size(Size * sizeof(double))));
};
template <>
struct Lane<1> {
  using type = double;
};

/// `Height` consecutive entries of a column in vector registers.
template <int Height>
struct Column {
  static constexpr int size = Height < lane_size ? Height : lane_size, count = Height / size;
  typename Lane<size>::type lanes[count];

  Column() = default;
  explicit Column(const double* from) {
#pragma GCC unroll 8
    for (int i = 0; i < count; ++i) __builtin_memcpy(&lanes[i], from + i * size, sizeof lanes[i]);
  }
  void store(double* to) const {
#pragma GCC unroll 8
    for (int i = 0; i < count; ++i) __builtin_memcpy(to + i * size, &lanes[i], sizeof lanes[i]);
  }
  void add(const Column& other, double factor) {
#pragma GCC unroll 8
    for (int i = 0; i < count; ++i) lanes[i] += other.lanes[i] * factor;
  }
  void scale(double factor) {
#pragma GCC unroll 8
    for (int i = 0; i < count; ++i) lanes[i] *= factor;
  }
};

/// The right-hand factor of a product as its matrix stands in memory, and transposed.
struct Plain {
  const double* data;
  Index stride;
  double operator()(Index i, Index j) const { return data[i + j * stride]; }
  [[nodiscard]] Plain from(Index i, Index j) const { return {data + i + j * stride, stride}; }
};
struct Transposed {
  const double* data;
  Index stride;
  double operator()(Index i, Index j) const { return data[i * stride + j]; }
  [[nodiscard]] Transposed from(Index i, Index j) const { return {data + i * stride + j, stride}; }
};

/// sum = A B of one tile, Height x Width.
template <int Height, int Width, class Right>
[[gnu::always_inline]] inline void product_of_tile(Index depth, const double* a, Index a_stride, Right b,
                                                   Column<Height> (&sum)[Width]) {
#pragma GCC unroll 8
  for (int j = 0; j < Width; ++j) sum[j] = Column<Height>{};
  for (Index k = 0; k < depth; ++k) {
    const Column<Height> column(a + k * a_stride);
#pragma GCC unroll 8
    for (int j = 0; j < Width; ++j) sum[j].add(column, b(k, j));
  }
}

/// C of one tile.
template <int Height, int Width, class Right>
[[gnu::always_inline]] inline void tile(Keep keep, Index depth, const double* a, Index a_stride, Right b, double* c,
                                        Index c_stride) {
  Column<Height> product[Width];
  product_of_tile<Height, Width>(depth, a, a_stride, b, product);
#pragma GCC unroll 8
  for (int j = 0; j < Width; ++j) {
    if (keep != Keep::nothing) {
      Column<Height> value(c + j * c_stride);
      value.add(product[j], keep == Keep::sum ? 1.0 : -1.0);
      product[j] = value;
    }
    product[j].store(c + j * c_stride);
  }
}

inline void copy_columns(Index rows, Index columns, const double* from, Index from_stride, double* to,
                         Index to_stride) {
  for (Index j = 0; j < columns; ++j)
    for (Index i = 0; i < rows; ++i) to[i + j * to_stride] = from[i + j * from_stride];
}

}  // namespace kalfem::KALFEM_KERNELS
