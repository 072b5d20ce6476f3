// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <vector>

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

  Eigen::VectorXd own, other;                                    ///< slots
  std::vector<std::optional<Eigen::Matrix<double, 8, 8>>> full;  ///< per tile, where it is needed

  /// y = A x for thin matrices, slots x columns.
  void apply(const Eigen::MatrixXd& x, Eigen::MatrixXd& y) const;
  /// One column of x <- A times that column.
  void apply_to_column(Eigen::MatrixXd& x, Eigen::Index column) const;
  /// y = A x of one tile; y may be x.
  void apply_to_tile(Eigen::Index tile, const double* x, double* y) const {
    if (const auto& block = full[static_cast<std::size_t>(tile)]) {
      Eigen::Map<Eigen::Matrix<double, 8, 1>>{y} = (*block * Eigen::Map<const Eigen::Matrix<double, 8, 1>>(x)).eval();
      return;
    }
    const Lanes values = load(x);
    store(y, load(&own[tile * tile_size]) * values + load(&other[tile * tile_size]) * swap_neighbours(values));
  }
};

}  // namespace kalfem
