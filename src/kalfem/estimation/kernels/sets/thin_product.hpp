// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/estimation/kernels/sets/register_tile.hpp"
#include "kalfem/estimation/kernels/vector_lanes.hpp"

namespace kalfem::KALFEM_KERNELS {

/// The right-hand factor, entry (k, j), as it stands or transposed.
struct Factor {
  const double* data;
  Index k_stride, j_stride;
};

/// `height` times eight rows and `width` columns of Y += sign X M: as many sums at once as hide the time of one.
template <int sign, int height, int width>
[[gnu::always_inline]] inline void add_block(Index rows, Index depth, const double* x, const Factor& m, double* y) {
  Lanes sum[height][width];
#pragma GCC unroll 8
  for (int r = 0; r < height; ++r)
#pragma GCC unroll 8
    for (int c = 0; c < width; ++c) sum[r][c] = load(y + c * rows + r * lane_count);
  for (Index k = 0; k < depth; ++k) {
    const double* factor = m.data + k * m.k_stride;
#pragma GCC unroll 8
    for (int r = 0; r < height; ++r) {
      const Lanes value = load(x + k * rows + r * lane_count);
#pragma GCC unroll 8
      for (int c = 0; c < width; ++c) sum[r][c] += value * (sign * factor[c * m.j_stride]);
    }
  }
#pragma GCC unroll 8
  for (int r = 0; r < height; ++r)
#pragma GCC unroll 8
    for (int c = 0; c < width; ++c) store(y + c * rows + r * lane_count, sum[r][c]);
}

/// All rows of `width` columns.
template <int sign, int width, int height = 8 / width>
void add_columns(Index row, Index rows, Index depth, const double* x, const Factor& m, double* y) {
  for (; rows - row >= height * lane_count; row += height * lane_count)
    add_block<sign, height, width>(rows, depth, x + row, m, y + row);
  if constexpr (height > 1)
    if (row < rows) add_columns<sign, width, height / 2>(row, rows, depth, x, m, y);
}

/// Y += sign X M, panels of columns from `j` on.
template <int sign, int width = 4>
void add(Index j, Index rows, Index columns, Index depth, const double* x, const Factor& m, double* y) {
  for (; columns - j >= width; j += width)
    add_columns<sign, width>(0, rows, depth, x, {m.data + j * m.j_stride, m.k_stride, m.j_stride}, y + j * rows);
  if constexpr (width > 1)
    if (j < columns) add<sign, width / 2>(j, rows, columns, depth, x, m, y);
}

/// Eight rows and `width` columns of M = X^T Y. Eight sums at once for each column, over every eighth row of Y: a
/// single one would wait for its own additions.
template <int width>
[[gnu::always_inline]] inline void inner_block(Index height, Index rows, const double* x, const double* y, double* m,
                                               Index m_rows) {
  Lanes sums[width][8] = {};
  for (Index row = 0; row < rows; row += lane_count)
#pragma GCC unroll 8
    for (int r = 0; r < lane_count; ++r) {
      const Lanes left = load(x + (row + r) * height);
#pragma GCC unroll 2
      for (int c = 0; c < width; ++c) sums[c][r] += left * y[c * rows + row + r];
    }
#pragma GCC unroll 2
  for (int c = 0; c < width; ++c) {
    const auto& sum = sums[c];
    store(m + c * m_rows, ((sum[0] + sum[1]) + (sum[2] + sum[3])) + ((sum[4] + sum[5]) + (sum[6] + sum[7])));
  }
}

inline void thin_add(double sign, Index rows, Index columns, Index depth, const double* x, KernelMatrix m, double* y) {
  const Factor factor{m.data, m.transposed ? m.stride : 1, m.transposed ? 1 : m.stride};
  if (sign > 0.0)
    add<1>(0, rows, columns, depth, x, factor, y);
  else
    add<-1>(0, rows, columns, depth, x, factor, y);
}

inline void thin_inner(Index height, Index rows, Index columns, const double* x, const double* y, double* m,
                       Index m_rows) {
  for (Index i = 0; i < height; i += lane_count) {
    Index j = 0;
    for (; j + 2 <= columns; j += 2) inner_block<2>(height, rows, x + i, y + j * rows, m + i + j * m_rows, m_rows);
    if (j < columns) inner_block<1>(height, rows, x + i, y + j * rows, m + i + j * m_rows, m_rows);
  }
}

}  // namespace kalfem::KALFEM_KERNELS
