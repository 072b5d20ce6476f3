// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <vector>

#include "kalfem/estimation/kernels/kernel_set.hpp"
#include "kalfem/estimation/kernels/vector_lanes.hpp"

namespace kalfem {

constexpr Eigen::Index tile_size = 8;

/// Places the states of a block diagonal propagator in tiles of eight slots, so that no block reaches over the edge of
/// a tile and pairs stand at even slots. Slots that stay empty are states of no variance.
struct TileLayout {
  std::vector<Eigen::Index> slot;  ///< of each state
  Eigen::Index tiles = 0;

  [[nodiscard]] Eigen::Index slots() const { return tiles * tile_size; }
  /// Rows of states in their slots, zero elsewhere: slots() x columns.
  [[nodiscard]] Eigen::MatrixXd placed(const Eigen::MatrixXd& states) const;
};

/// Nothing where a block of A is larger than a tile.
std::optional<TileLayout> tile_layout(const Eigen::MatrixXd& A);

/// A block diagonal matrix in its tiles: where a tile holds only blocks of one and two, y_i = own_i x_i + other_i
/// x_partner(i) with the partner the neighbour in the pair; else a full 8 x 8 block.
struct TiledPropagator {
  TiledPropagator() = default;
  TiledPropagator(const Eigen::MatrixXd& A, const TileLayout& layout);

  Eigen::VectorXd own, other;            ///< slots
  std::vector<Eigen::Index> full_place;  ///< of each tile in `full`; -1 where pairs do
  Eigen::VectorXd full;                  ///< 64 numbers a tile, by columns

  [[nodiscard]] KernelPropagator view() const { return {own.data(), other.data(), {full.data(), full_place.data()}}; }
  /// y = A x for thin matrices, slots x columns; y may be x.
  void apply(const Eigen::MatrixXd& x, Eigen::MatrixXd& y) const;
};

}  // namespace kalfem
