// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/kernels/packed_product.hpp"

namespace kalfem::tiles {

using Eigen::Index;

namespace {

constexpr int height = tile_height, width = tile_width;
constexpr Index block_depth = 32 * width;  ///< a panel of B of this depth stays in the first cache
constexpr Index block_rows = 8 * height;   ///< a block of A of these rows in the second

/// Storage of the calling thread, for at least `size` numbers.
double* storage(Eigen::VectorXd& kept, Index size) {
  if (kept.size() < size) kept.resize(size);
  return kept.data();
}
thread_local Eigen::VectorXd packed_left, packed_right;

constexpr Index round_up(Index value, Index step) { return (value + step - 1) / step * step; }

/// Slabs of `height` rows, each stored by columns; the last is filled with zeros.
void pack_left(Index rows, Index depth, const double* a, Index stride, double* to) {
  for (; rows >= height; rows -= height, a += height)
    for (Index k = 0; k < depth; ++k, to += height) Column<height>(a + k * stride).store(to);
  if (rows == 0) return;
  for (Index k = 0; k < depth; ++k, to += height) {
    for (Index i = 0; i < rows; ++i) to[i] = a[i + k * stride];
    for (Index i = rows; i < height; ++i) to[i] = 0.0;
  }
}

/// One panel of up to `width` columns stored by rows, filled with zeros.
template <class Right>
void pack_right(Index depth, Index columns, Right b, double* to) {
  if (columns == width) {
    for (Index k = 0; k < depth; ++k, to += width)
#pragma GCC unroll 8
      for (int j = 0; j < width; ++j) to[j] = b(k, j);
    return;
  }
  for (Index k = 0; k < depth; ++k, to += width)
    for (Index j = 0; j < width; ++j) to[j] = j < columns ? b(k, j) : 0.0;
}

/// A tile of which only part is wanted, by way of a whole one.
template <int Height>
void partial_tile(Keep keep, Index depth, const double* a, Transposed b, double* c, Index c_stride, Index rows,
                  Index columns) {
  double product[Height * width];
  tile<Height, width>(Keep::nothing, depth, a, height, b, product, Height);
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
  if (rows >= Height && columns >= width)
    tile<Height, width>(keep, depth, a, height, b, c, c_stride);
  else
    partial_tile<Height>(keep, depth, a, b, c, c_stride, rows, columns);
}

/// The rows of a slab from its lane `first` on.
void slab(Keep keep, Index first, Index depth, const double* a, Transposed b, double* c, Index c_stride, Index rows,
          Index columns) {
  const Index left = std::min<Index>(rows, height) - first * lane_size;
  a += first * lane_size, c += first * lane_size;
  if (left > 2 * lane_size)
    tile_of<height>(keep, depth, a, b, c, c_stride, left, columns);
  else if (left > lane_size)
    tile_of<2 * lane_size>(keep, depth, a, b, c, c_stride, left, columns);
  else if (left > 0)
    tile_of<lane_size>(keep, depth, a, b, c, c_stride, left, columns);
}

}  // namespace

template <class Right>
void packed_product(Keep keep, Shape shape, Index rows, Index columns, Index depth, const double* a, Index a_stride,
                    Right b, double* c, Index c_stride) {
  double* const left = storage(packed_left, block_rows * std::min(depth, block_depth));
  double* const right = storage(packed_right, round_up(columns, width) * std::min(depth, block_depth));
  for (Index k0 = 0; k0 < depth; k0 += block_depth) {
    const Index block = std::min(depth - k0, block_depth);
    const Index columns_here = shape == Shape::lower_factor ? std::min(columns, k0 + block) : columns;
    const auto skipped = [&](Index j) { return shape == Shape::lower_factor ? std::max<Index>(j - k0, 0) : 0; };
    for (Index j = 0; j < columns_here; j += width) {
      const Index k = skipped(j);
      pack_right(block - k, std::min<Index>(columns - j, width), b.from(k0 + k, j), right + (j * block + k * width));
    }
    for (Index i0 = 0; i0 < rows; i0 += block_rows) {
      const Index rows_here = std::min(rows - i0, block_rows);
      pack_left(rows_here, block, a + i0 + k0 * a_stride, a_stride, left);
      const Index end = shape == Shape::lower_result ? std::min(columns, i0 + rows_here) : columns_here;
      for (Index j = 0; j < end; j += width) {
        const Index k = skipped(j), depth_here = block - k;
        const bool first = k0 == 0 || (shape == Shape::lower_factor && j >= k0);
        const Keep here = keep == Keep::nothing && !first ? Keep::sum : keep;
        const Transposed panel{right + (j * block + k * width), width};
        const Index top = shape == Shape::lower_result ? std::max<Index>(j - i0, 0) : 0;
        for (Index i = top - top % height; i < rows_here; i += height)
          slab(here, std::max<Index>(top - i, 0) / lane_size, depth_here, left + (i * block + k * height), panel,
               c + i0 + i + j * c_stride, c_stride, rows_here - i, std::min<Index>(columns - j, width));
      }
    }
  }
}

template void packed_product(Keep, Shape, Index, Index, Index, const double*, Index, Plain, double*, Index);
template void packed_product(Keep, Shape, Index, Index, Index, const double*, Index, Transposed, double*, Index);

}  // namespace kalfem::tiles
