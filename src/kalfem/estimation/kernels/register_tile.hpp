// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstring>

namespace kalfem::tiles {

// Products of small tiles whose sums stay in vector registers, written for any vector width. Matrices are stored by
// columns; a `stride` is the distance between columns.

#if defined(__AVX512F__)
constexpr int lane_size = 8;    ///< numbers in a vector register
constexpr int lane_count = 32;  ///< vector registers
#elif defined(__AVX__)
constexpr int lane_size = 4;
constexpr int lane_count = 16;
#else
constexpr int lane_size = 2;
constexpr int lane_count = 16;
#endif

/// The largest tile whose sums stay in registers beside a column of the left factor.
constexpr int tile_height = (lane_count == 32 ? 3 : 2) * lane_size;
constexpr int tile_width = lane_count == 32 ? 8 : 6;

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
  static constexpr int size = std::min(Height, lane_size), count = Height / size;
  typename Lane<size>::type lanes[count];

  Column() = default;
  explicit Column(const double* from) {
#pragma GCC unroll 8
    for (int i = 0; i < count; ++i) std::memcpy(&lanes[i], from + i * size, sizeof lanes[i]);
  }
  void store(double* to) const {
#pragma GCC unroll 8
    for (int i = 0; i < count; ++i) std::memcpy(to + i * size, &lanes[i], sizeof lanes[i]);
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
  Eigen::Index stride;
  double operator()(Eigen::Index i, Eigen::Index j) const { return data[i + j * stride]; }
  [[nodiscard]] Plain from(Eigen::Index i, Eigen::Index j) const { return {data + i + j * stride, stride}; }
};
struct Transposed {
  const double* data;
  Eigen::Index stride;
  double operator()(Eigen::Index i, Eigen::Index j) const { return data[i * stride + j]; }
  [[nodiscard]] Transposed from(Eigen::Index i, Eigen::Index j) const { return {data + i * stride + j, stride}; }
};

/// What becomes of a product A B and what stood in its place C: A B, C + A B, C - A B.
enum class Keep { nothing, sum, difference };

/// Which part of a product is wanted or not zero: all, only the lower triangle of the result, or the right-hand factor
/// is lower triangular.
enum class Shape { full, lower_result, lower_factor };

/// sum = A B of one tile, Height x Width.
template <int Height, int Width, class Right>
[[gnu::always_inline]] inline void product_of_tile(Eigen::Index depth, const double* a, Eigen::Index a_stride, Right b,
                                                   Column<Height> (&sum)[Width]) {
#pragma GCC unroll 8
  for (int j = 0; j < Width; ++j) sum[j] = Column<Height>{};
  for (Eigen::Index k = 0; k < depth; ++k) {
    const Column<Height> column(a + k * a_stride);
#pragma GCC unroll 8
    for (int j = 0; j < Width; ++j) sum[j].add(column, b(k, j));
  }
}

/// C of one tile.
template <int Height, int Width, class Right>
[[gnu::always_inline]] inline void tile(Keep keep, Eigen::Index depth, const double* a, Eigen::Index a_stride, Right b,
                                        double* c, Eigen::Index c_stride) {
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

}  // namespace kalfem::tiles
