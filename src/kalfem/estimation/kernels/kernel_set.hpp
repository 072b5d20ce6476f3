// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace kalfem {

// The loops in which a filter's step spends its time, compiled once for each width of vector registers: which of them a
// program runs is decided when it starts. A set knows numbers in memory only, and includes no header with inline
// functions, as a linker may take such a function from any file, also from one compiled for another processor.

/// What becomes of a product A B and what stood in its place C: A B, C + A B, C - A B.
enum class Keep { nothing, sum, difference };

/// Which part of a product is wanted or not zero: all, only the lower triangle of the result, or the right-hand factor
/// is lower triangular.
enum class Shape { full, lower_result, lower_factor };

/// A matrix by columns, or a factor in a product as its transpose stands in memory.
struct KernelMatrix {
  const double* data;
  std::ptrdiff_t stride;  ///< between columns
  bool transposed = false;
};

/// Tiles of 8 x 8 one after the other, those that are zero or not needed left out.
struct KernelTiles {
  const double* values;         ///< 64 a tile, by columns
  const std::ptrdiff_t* place;  ///< where a tile's begin; negative: left out

  [[nodiscard]] const double* tile(std::ptrdiff_t number) const {
    return place[number] < 0 ? nullptr : values + place[number];
  }
};

/// A block diagonal matrix, see TiledPropagator: `own` and `other` of each slot, and its full tiles.
struct KernelPropagator {
  const double *own, *other;
  KernelTiles full;
};

/// One pass over the lower triangle of a covariance in tiles, see CovarianceTiles::pass().
struct TilePass {
  std::ptrdiff_t begin, end;                ///< rows of tiles
  std::ptrdiff_t terms, projected, stride;  ///< of the packed thin columns
  const double* packed;
  const KernelPropagator* propagator;  ///< A, or null
  const KernelTiles* noise;            ///< Q, of the lower triangle by rows; or null
  double widening;                     ///< of the variances, before anything else
  double* values;                      ///< P
  double* product;                     ///< P H, which the tiles are added to
};

/// All matrices are stored by columns. Pointers of `thin` functions and tiles are aligned to 64 bytes, their numbers of
/// rows are multiples of eight.
struct KernelSet {
  const char* name;
  /// C <- A B, C + A B or C - A B with A rows x depth; entries above the diagonal are left without meaning with
  /// Shape::lower_result.
  void (*product)(Keep keep, Shape shape, std::ptrdiff_t rows, std::ptrdiff_t columns, std::ptrdiff_t depth,
                  KernelMatrix a, KernelMatrix b, double* c, std::ptrdiff_t c_stride);
  /// P = L L^T in place of the lower triangle; false where a pivot is not larger than `pivot_floor` times the variance
  /// that stands `variance_step` behind the one before.
  bool (*cholesky)(std::ptrdiff_t n, double pivot_floor, const double* variances, std::ptrdiff_t variance_step,
                   double* l);
  /// Y += sign X M, or X M^T, with the first `depth` columns of X.
  void (*thin_add)(double sign, std::ptrdiff_t rows, std::ptrdiff_t columns, std::ptrdiff_t depth, const double* x,
                   KernelMatrix m, double* y);
  /// M = X^T Y, X^T as it stands with `height` rows.
  void (*thin_inner)(std::ptrdiff_t height, std::ptrdiff_t rows, std::ptrdiff_t columns, const double* x,
                     const double* y, double* m, std::ptrdiff_t m_rows);
  /// y = A x of one column; y may be x.
  void (*propagate)(const KernelPropagator& a, std::ptrdiff_t tiles, const double* x, double* y);
  void (*pass_over)(const TilePass& pass);
};

/// Those of the width of vector registers that the program runs with, see vector_width().
const KernelSet& kernels();

/// Storage of the calling thread for at least `size` numbers, which stays, so that only a growing size allocates:
/// `which` is 0 or 1.
double* kernel_storage(int which, std::ptrdiff_t size);

}  // namespace kalfem
