// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/estimation/kernels/sets/register_tile.hpp"

namespace kalfem::KALFEM_KERNELS {

constexpr Index block_depth = 32 * tile_width;  ///< a panel of B of this depth stays in the first cache
constexpr Index block_rows = 8 * tile_height;   ///< a block of A of these rows in the second

constexpr Index round_up(Index value, Index step) { return (value + step - 1) / step * step; }

/// Slabs of `tile_height` rows, each stored by columns; the last is filled with zeros.
inline void pack_left(Index rows, Index depth, const double* a, Index stride, double* to) {
  for (; rows >= tile_height; rows -= tile_height, a += tile_height)
    for (Index k = 0; k < depth; ++k, to += tile_height) Column<tile_height>(a + k * stride).store(to);
  if (rows == 0) return;
  for (Index k = 0; k < depth; ++k, to += tile_height) {
    for (Index i = 0; i < rows; ++i) to[i] = a[i + k * stride];
    for (Index i = rows; i < tile_height; ++i) to[i] = 0.0;
  }
}

/// One panel of up to `tile_width` columns stored by rows, filled with zeros.
template <class Right>
void pack_right(Index depth, Index columns, Right b, double* to) {
  if (columns == tile_width) {
    for (Index k = 0; k < depth; ++k, to += tile_width)
#pragma GCC unroll 8
      for (int j = 0; j < tile_width; ++j) to[j] = b(k, j);
    return;
  }
  for (Index k = 0; k < depth; ++k, to += tile_width)
    for (Index j = 0; j < tile_width; ++j) to[j] = j < columns ? b(k, j) : 0.0;
}

/// A tile of which only part is wanted, by way of a whole one.
template <int Height>
void partial_tile(Keep keep, Index depth, const double* a, Transposed b, double* c, Index c_stride, Index rows,
                  Index columns) {
  double product[Height * tile_width];
  tile<Height, tile_width>(Keep::nothing, depth, a, tile_height, b, product, Height);
  for (Index j = 0; j < columns; ++j)
    for (Index i = 0; i < rows; ++i) {
      double& value = c[i + j * c_stride];
      const double term = product[i + j * Height];
      value = keep == Keep::nothing ? term : keep == Keep::sum ? value + term : value - term;
    }
}

template <int Height>
[[gnu::noinline]] void tile_of(Keep keep, Index depth, const double* a, Transposed b, double* c, Index c_stride,
                               Index rows, Index columns) {
  if (rows >= Height && columns >= tile_width)
    tile<Height, tile_width>(keep, depth, a, tile_height, b, c, c_stride);
  else
    partial_tile<Height>(keep, depth, a, b, c, c_stride, rows, columns);
}

/// The rows of a slab from its lane `first` on.
inline void slab(Keep keep, Index first, Index depth, const double* a, Transposed b, double* c, Index c_stride,
                 Index rows, Index columns) {
  const Index left = least(rows, tile_height) - first * lane_size;
  a += first * lane_size, c += first * lane_size;
  if (left > 2 * lane_size)
    tile_of<tile_height>(keep, depth, a, b, c, c_stride, left, columns);
  else if (left > lane_size)
    tile_of<2 * lane_size>(keep, depth, a, b, c, c_stride, left, columns);
  else if (left > 0)
    tile_of<lane_size>(keep, depth, a, b, c, c_stride, left, columns);
}

/// C = A B, C += A B or C -= A B for factors beyond the nearest cache: blocks of both are first copied in the order in
/// which the tiles read them [Goto and van de Geijn 2008, ACM Trans. Math. Softw. 34(3), 12]. A is rows x depth, B is
/// depth x columns. With Shape::lower_result entries above the diagonal are left without meaning.
template <class Right>
void packed_product(Keep keep, Shape shape, Index rows, Index columns, Index depth, const double* a, Index a_stride,
                    Right b, double* c, Index c_stride) {
  double* const left = kernel_storage(0, block_rows * least(depth, block_depth));
  double* const right = kernel_storage(1, round_up(columns, tile_width) * least(depth, block_depth));
  for (Index k0 = 0; k0 < depth; k0 += block_depth) {
    const Index block = least(depth - k0, block_depth);
    const Index columns_here = shape == Shape::lower_factor ? least(columns, k0 + block) : columns;
    const auto skipped = [&](Index j) { return shape == Shape::lower_factor ? most(j - k0, 0) : 0; };
    for (Index j = 0; j < columns_here; j += tile_width) {
      const Index k = skipped(j);
      pack_right(block - k, least(columns - j, tile_width), b.from(k0 + k, j), right + (j * block + k * tile_width));
    }
    for (Index i0 = 0; i0 < rows; i0 += block_rows) {
      const Index rows_here = least(rows - i0, block_rows);
      pack_left(rows_here, block, a + i0 + k0 * a_stride, a_stride, left);
      const Index end = shape == Shape::lower_result ? least(columns, i0 + rows_here) : columns_here;
      for (Index j = 0; j < end; j += tile_width) {
        const Index k = skipped(j), depth_here = block - k;
        const bool first = k0 == 0 || (shape == Shape::lower_factor && j >= k0);
        const Keep here = keep == Keep::nothing && !first ? Keep::sum : keep;
        const Transposed panel{right + (j * block + k * tile_width), tile_width};
        const Index top = shape == Shape::lower_result ? most(j - i0, 0) : 0;
        for (Index i = top - top % tile_height; i < rows_here; i += tile_height)
          slab(here, most(top - i, 0) / lane_size, depth_here, left + (i * block + k * tile_height), panel,
               c + i0 + i + j * c_stride, c_stride, rows_here - i, least(columns - j, tile_width));
      }
    }
  }
}

}  // namespace kalfem::KALFEM_KERNELS
