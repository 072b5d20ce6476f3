// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/estimation/kernels/sets/register_tile.hpp"
#include "kalfem/estimation/kernels/vector_lanes.hpp"

namespace kalfem::KALFEM_KERNELS {

/// One tile in registers, column by column.
using Tile = Lanes[8];
constexpr Index tile_numbers = 64;

[[gnu::always_inline]] inline void load_tile(const double* from, Tile& t) {
#pragma GCC unroll 8
  for (int j = 0; j < 8; ++j) t[j] = load(from + j * 8);
}

[[gnu::always_inline]] inline void store_tile(const Tile& t, double* to) {
#pragma GCC unroll 8
  for (int j = 0; j < 8; ++j) store(to + j * 8, t[j]);
}

/// T += sum of left_I right_J^T over `terms` pairs of columns.
[[gnu::always_inline]] inline void add_products(Index terms, const double* left, const double* right, Tile& t) {
  for (Index c = 0; c < terms; ++c) {
    const Lanes column = load(left + c * 8);
    const double* row = right + c * 8;
#pragma GCC unroll 8
    for (int j = 0; j < 8; ++j) t[j] += column * row[j];
  }
}

/// T <- A_I T A_J^T with pairs.
[[gnu::always_inline]] inline void propagate_pairs(const KernelPropagator& a, Index row, Index column, Tile& t) {
  const double *own = a.own + column * 8, *other = a.other + column * 8;
#pragma GCC unroll 4
  for (int j = 0; j < 8; j += 2) {
    const Lanes first = t[j], second = t[j + 1];
    t[j] = first * own[j] + second * other[j];
    t[j + 1] = second * own[j + 1] + first * other[j + 1];
  }
  const Lanes left = load(a.own + row * 8), across = load(a.other + row * 8);
#pragma GCC unroll 8
  for (int j = 0; j < 8; ++j) t[j] = left * t[j] + across * swap_neighbours(t[j]);
}

/// The tile of A, where it is a full one or is made of its pairs.
inline const double* whole_tile(const KernelPropagator& a, Index tile, double* made) {
  if (const double* full = a.full.tile(tile)) return full;
  for (Index i = 0; i < tile_numbers; ++i) made[i] = 0.0;
  for (Index i = 0; i < 8; ++i) {
    made[i + 8 * i] = a.own[tile * 8 + i];
    made[i + 8 * (i ^ 1)] = a.other[tile * 8 + i];
  }
  return made;
}

/// The same where a tile of A has larger blocks.
[[gnu::noinline]] inline void propagate_full(const KernelPropagator& a, Index row, Index column, double* values) {
  alignas(64) double of_row[tile_numbers], of_column[tile_numbers];
  const double *left = whole_tile(a, row, of_row), *right = whole_tile(a, column, of_column);
  Tile moved;
  for (int j = 0; j < 8; ++j) {
    moved[j] = Lanes{};
    for (int k = 0; k < 8; ++k) moved[j] += load(left + 8 * k) * values[k + 8 * j];
  }
  for (int j = 0; j < 8; ++j) {
    Lanes sum = {};
    for (int k = 0; k < 8; ++k) sum += moved[k] * right[j + 8 * k];
    store(values + 8 * j, sum);
  }
}

/// Y_I += T H_J.
[[gnu::always_inline]] inline void multiply_tile(const Tile& t, Index columns, const double* h, double* y) {
  for (Index c = 0; c < columns; ++c) {
    const double* factor = h + c * 8;
    double* to = y + c * 8;
    const Lanes even = (t[0] * factor[0] + t[2] * factor[2]) + (t[4] * factor[4] + t[6] * factor[6]);
    const Lanes odd = (t[1] * factor[1] + t[3] * factor[3]) + (t[5] * factor[5] + t[7] * factor[7]);
    store(to, load(to) + (even + odd));
  }
}

/// y = A x of one column; y may be x.
inline void propagate(const KernelPropagator& a, Index tiles, const double* x, double* y) {
  for (Index tile = 0; tile < tiles; ++tile, x += 8, y += 8) {
    const Lanes values = load(x);
    if (const double* full = a.full.tile(tile)) {
      Lanes sum = {};
      for (int k = 0; k < 8; ++k) sum += load(full + 8 * k) * values[k];
      store(y, sum);
    } else {
      store(y, load(a.own + tile * 8) * values + load(a.other + tile * 8) * swap_neighbours(values));
    }
  }
}

inline void pass_over(const TilePass& pass) {
  const Index terms = pass.terms, projected = pass.projected;
  const KernelPropagator* a = pass.propagator;
  for (Index row = pass.begin; row < pass.end; ++row) {
    const bool full_row = a != nullptr && a->full.tile(row) != nullptr;
    const double* of_row = pass.packed + row * pass.stride;
    for (Index column = 0; column <= row; ++column) {
      const double* of_column = pass.packed + column * pass.stride;
      const Index place = row * (row + 1) / 2 + column;
      double* values = pass.values + place * tile_numbers;
      if (row == column)
        for (int i = 0; i < 8; ++i) values[9 * i] *= pass.widening;
      const bool full = full_row || (a != nullptr && a->full.tile(column) != nullptr);
      if (full) [[unlikely]]
        propagate_full(*a, row, column, values);
      Tile t;
      load_tile(values, t);
      if (a != nullptr && !full) propagate_pairs(*a, row, column, t);
      add_products(terms, of_row, of_column + terms * 8, t);
      if (const double* noise = pass.noise != nullptr ? pass.noise->tile(place) : nullptr) {
#pragma GCC unroll 8
        for (int i = 0; i < 8; ++i) t[i] += load(noise + i * 8);
      }
      Tile mirrored;
      transpose(t, mirrored);
      if (row == column) {
#pragma GCC unroll 8
        for (int i = 0; i < 8; ++i) t[i] = 0.5 * (t[i] + mirrored[i]);
      } else {
        multiply_tile(mirrored, projected, of_row + 2 * terms * 8, pass.product + column * projected * 8);
      }
      store_tile(t, values);
      multiply_tile(t, projected, of_column + 2 * terms * 8, pass.product + row * projected * 8);
    }
  }
}

}  // namespace kalfem::KALFEM_KERNELS
