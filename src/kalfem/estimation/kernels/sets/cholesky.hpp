// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/estimation/kernels/sets/product.hpp"

namespace kalfem::KALFEM_KERNELS {

/// Up to so many columns a Cholesky factor is formed at once, in the nearest cache; wider ones by halves.
constexpr Index narrow = 64;

/// Columns of a panel behind its diagonal block L_J: X <- (C - A B) L_J^-T, one tile of rows at a time.
template <int Height, int Width>
[[gnu::always_inline]] inline void solve_tile(Index depth, const double* a, Index stride, Transposed b,
                                              const double* block, Index block_stride, const double* inverse,
                                              double* c) {
  Column<Height> x[Width];
  product_of_tile<Height, Width>(depth, a, stride, b, x);
#pragma GCC unroll 8
  for (int j = 0; j < Width; ++j) {
    Column<Height> value(c + j * stride);
    value.add(x[j], -1.0);
    for (int k = 0; k < j; ++k) value.add(x[k], -block[j + k * block_stride]);
    value.scale(inverse[j]);
    value.store(c + j * stride);
    x[j] = value;
  }
}

template <int Width, int Height = tallest>
[[gnu::noinline]] void solve_panel(Index row, Index rows, Index depth, const double* a, Index stride, Transposed b,
                                   const double* block, const double* inverse, double* c) {
  for (; rows - row >= Height; row += Height)
    solve_tile<Height, Width>(depth, a + row, stride, b, block, stride, inverse, c + row);
  if constexpr (Height > 1)
    if (row < rows) solve_panel<Width, Height / 2>(row, rows, depth, a, stride, b, block, inverse, c);
}

/// Smallest pivots: a share of the variances, those of the matrix before anything was subtracted.
struct PivotFloor {
  double share;
  const double* variance;
  Index step;
  double operator[](Index i) const { return share * variance[i * step]; }
  [[nodiscard]] PivotFloor from(Index i) const { return {share, variance + i * step, step}; }
};

/// Factor of the diagonal block in place and the inverses of its diagonal. Columns are divided by their pivots, not by
/// the roots, while others wait for them: the roots are taken aside.
template <int Width>
inline bool factor_block(double* block, Index stride, PivotFloor floor, double* inverse) {
  double column[Width][Width], divided[Width][Width];
#pragma GCC unroll 8
  for (int j = 0; j < Width; ++j) {
#pragma GCC unroll 8
    for (int i = j; i < Width; ++i) {
      column[j][i] = block[i + j * stride];
#pragma GCC unroll 8
      for (int k = 0; k < j; ++k) column[j][i] -= column[k][i] * divided[k][j];
    }
    const double pivot = column[j][j], inverse_pivot = 1.0 / pivot;
    if (!(pivot > floor[j])) return false;
#pragma GCC unroll 8
    for (int i = j; i < Width; ++i) divided[j][i] = column[j][i] * inverse_pivot;
    const double root = __builtin_sqrt(pivot);
    block[j + j * stride] = root;
    inverse[j] = 1.0 / root;
#pragma GCC unroll 8
    for (int i = j + 1; i < Width; ++i) block[i + j * stride] = column[j][i] * inverse[j];
  }
  return true;
}

/// Columns j ... j + Width - 1 of L from those before (left-looking).
template <int Width>
bool factor_panel(Index j, Index n, PivotFloor floor, double* l) {
  double* block = l + j + j * n;
  double inverse[Width];
  const Transposed before{l + j, n};  // L_J^T
  tile<Width, Width>(Keep::difference, j, l + j, n, before, block, n);
  if (!factor_block<Width>(block, n, floor.from(j), inverse)) return false;
  solve_panel<Width>(j + Width, n, j, l, n, before, block, inverse, l + j * n);
  return true;
}

/// P = L L^T in place, contiguous.
inline bool narrow_cholesky(Index n, PivotFloor floor, double* l) {
  Index j = 0;
  for (; n - j >= 4; j += 4)
    if (!factor_panel<4>(j, n, floor, l)) return false;
  for (; j < n; ++j)
    if (!factor_panel<1>(j, n, floor, l)) return false;
  return true;
}

/// X <- X L^-T for the few columns of a narrow contiguous L, some rows at a time in the nearest cache.
inline void narrow_solve(Index rows, Index n, const double* lower, double* x, Index stride) {
  constexpr int height = tile_height;
  alignas(64) double slab[height * narrow];
  double inverse[narrow];
  for (Index j = 0; j < n; ++j) inverse[j] = 1.0 / lower[j + j * n];
  for (Index i = 0; i < height * n; ++i) slab[i] = 0.0;
  for (Index row = 0; row < rows; row += height) {
    const Index here = least(rows - row, height);
    copy_columns(here, n, x + row, stride, slab, height);
    Index j = 0;
    for (; n - j >= 4; j += 4)
      solve_tile<height, 4>(j, slab, height, {lower + j, n}, lower + j + j * n, n, inverse + j, slab + j * height);
    for (; j < n; ++j)
      solve_tile<height, 1>(j, slab, height, {lower + j, n}, lower + j + j * n, n, inverse + j, slab + j * height);
    copy_columns(here, n, slab, height, x + row, stride);
  }
}

inline Index half(Index n) { return (n / 2 + lane_size - 1) / lane_size * lane_size; }

/// X <- X L^-T by halves: X_1 <- X_1 L_11^-T, X_2 <- (X_2 - X_1 L_21^T) L_22^-T.
inline void solve_rows(Index rows, Index n, const double* lower, double* x, Index stride) {
  if (n <= narrow) {
    alignas(64) double contiguous[narrow * narrow];
    copy_columns(n, n, lower, stride, contiguous, n);
    narrow_solve(rows, n, contiguous, x, stride);
    return;
  }
  const Index first = half(n), second = n - first;
  double* right = x + first * stride;
  solve_rows(rows, first, lower, x, stride);
  product(Keep::difference, Shape::full, rows, second, first, x, stride, Transposed{lower + first, stride}, right,
          stride);
  solve_rows(rows, second, lower + first * (stride + 1), right, stride);
}

/// P = L L^T in place by halves: L_11, L_21 = P_21 L_11^-T, P_22 - L_21 L_21^T.
inline bool factor_in_place(Index n, PivotFloor floor, double* l, Index stride) {
  if (n <= narrow) {
    alignas(64) double contiguous[narrow * narrow];
    copy_columns(n, n, l, stride, contiguous, n);
    const bool usable = narrow_cholesky(n, floor, contiguous);
    copy_columns(n, n, contiguous, n, l, stride);
    return usable;
  }
  const Index first = half(n), second = n - first;
  double *below = l + first, *rest = below + first * stride;
  if (!factor_in_place(first, floor, l, stride)) return false;
  solve_rows(second, first, l, below, stride);
  product(Keep::difference, Shape::lower_result, second, second, first, below, stride, Transposed{below, stride}, rest,
          stride);
  return factor_in_place(second, floor.from(first), rest, stride);
}

inline bool cholesky(Index n, double pivot_floor, const double* variances, Index variance_step, double* l) {
  const PivotFloor floor{pivot_floor, variances, variance_step};
  return n <= narrow ? narrow_cholesky(n, floor, l) : factor_in_place(n, floor, l, n);
}

}  // namespace kalfem::KALFEM_KERNELS
