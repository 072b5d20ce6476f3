// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/estimation/kernels/sets/packed_product.hpp"

namespace kalfem::KALFEM_KERNELS {

// Where the method changes, measured on processors with AVX-512 and a second cache of 1 MB; neighbouring values differ
// by a few per cent.

/// Up to so many rows and columns, and a depth of twice as many and one, factors are read where they stand; larger ones
/// are copied first, unless one side is so thin that the copy is not read often enough.
constexpr Index largest_direct = 160, thinnest_packed = 40;
/// Tile of products that read their factors where they stand: at some tens of rows a small one loses less at the edges.
constexpr int tallest = 2 * lane_size < 8 ? 2 * lane_size : 8, widest = 6;

/// `Width` columns and the rows from `row` on.
template <int Width, int Height = tallest, class Right>
[[gnu::noinline]] void panel(Keep keep, Index row, Index rows, Index depth, const double* a, Index a_stride, Right b,
                             double* c, Index c_stride) {
  for (; rows - row >= Height; row += Height) tile<Height, Width>(keep, depth, a + row, a_stride, b, c + row, c_stride);
  if constexpr (Height > 1)
    if (row < rows) panel<Width, Height / 2>(keep, row, rows, depth, a, a_stride, b, c, c_stride);
}

/// Panels of columns from `j` on, the factors read where they stand.
template <int Width = widest, class Right>
void direct_product(Keep keep, Shape shape, Index j, Index rows, Index columns, Index depth, const double* a,
                    Index a_stride, Right b, double* c, Index c_stride) {
  for (; columns - j >= Width; j += Width) {
    const Index row = shape == Shape::lower_result ? j - j % lane_size : 0, k = shape == Shape::lower_factor ? j : 0;
    panel<Width>(keep, row, rows, depth - k, a + k * a_stride, a_stride, b.from(k, j), c + j * c_stride, c_stride);
  }
  if constexpr (Width > 1)
    if (j < columns)
      direct_product<Width == widest ? 4 : Width / 2>(keep, shape, j, rows, columns, depth, a, a_stride, b, c,
                                                      c_stride);
}

template <class Right>
void product(Keep keep, Shape shape, Index rows, Index columns, Index depth, const double* a, Index a_stride, Right b,
             double* c, Index c_stride) {
  const bool outgrown = most(rows, columns) > largest_direct || depth > 2 * largest_direct + 1;
  if (outgrown && least(rows, depth) >= thinnest_packed)
    packed_product(keep, shape, rows, columns, depth, a, a_stride, b, c, c_stride);
  else
    direct_product(keep, shape, 0, rows, columns, depth, a, a_stride, b, c, c_stride);
}

}  // namespace kalfem::KALFEM_KERNELS
