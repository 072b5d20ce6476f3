// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <vector>

#include "kalfem/base/worker_pool.hpp"
#include "kalfem/estimation/kernels/tile_layout.hpp"

namespace kalfem {

/// A symmetric matrix of constant value, as process noise is: tiles of zeros are not stored.
class SymmetricTiles {
public:
  SymmetricTiles() = default;
  SymmetricTiles(const Eigen::MatrixXd& matrix, const TileLayout& layout);
  /// Of the lower triangle, by rows.
  [[nodiscard]] KernelTiles view() const { return {values_.data(), place_.data()}; }

private:
  std::vector<Eigen::Index> place_;
  Eigen::VectorXd values_;
};

/// What one pass over the covariance does to it,
///     P <- A (widened P - J J^T) A^T + W U^T + U W^T + Q,
/// and the thin product that it forms of the new P on the way, P H. All with one row a slot.
struct CovarianceStep {
  const Eigen::MatrixXd* downdate = nullptr;      ///< J, or none
  const TiledPropagator* propagator = nullptr;    ///< A, or none: A = 1, U, W and Q absent
  const Eigen::MatrixXd* gain = nullptr;          ///< U
  const Eigen::MatrixXd* response = nullptr;      ///< W
  const SymmetricTiles* process_noise = nullptr;  ///< Q
  const Eigen::MatrixXd* projected = nullptr;     ///< H
};

/// The lower triangle of a covariance in tiles of 8 x 8, one after the other in memory, so that one pass over it reads
/// and writes every entry once and meets all that concerns a tile while it is in registers. Passes over large matrices
/// are split into parts whose sums are added in a fixed order, so results do not depend on the number of threads.
class CovarianceTiles {
public:
  /// Passes over large matrices are shared by so many threads.
  explicit CovarianceTiles(int threads = 1);

  void reset(const Eigen::MatrixXd& covariance, const TileLayout& layout);

  /// Variances are widened by `rounding_allowance` of themselves before a downdate, a little more than what rounding
  /// can take from them, so that P stays positive semi-definite where a measurement leaves almost nothing.
  /// P H goes into the first columns of `product`.
  void pass(const CovarianceStep& step, Eigen::MatrixXd& product);

  /// Column of P.
  void column(Eigen::Index slot, double* out) const;
  /// Variances of the eight states of a tile.
  void diagonal(Eigen::Index at, double* out) const {
    for (Eigen::Index i = 0; i < tile_size; ++i) out[i] = tile(at, at)[i * (tile_size + 1)];
  }
  /// P of two slots.
  [[nodiscard]] double entry(Eigen::Index one, Eigen::Index other) const;
  /// P in the order of the states.
  [[nodiscard]] Eigen::MatrixXd matrix(const TileLayout& layout) const;

  /// Its values, to or from an archive; of tiles that were reset() before.
  void transfer(auto& archive) { archive(values_); }
  void transfer(auto& archive) const { archive(values_); }

private:
  double* tile(Eigen::Index row, Eigen::Index column) {
    return values_.data() + (row * (row + 1) / 2 + column) * tile_size * tile_size;
  }
  [[nodiscard]] const double* tile(Eigen::Index row, Eigen::Index column) const {
    return values_.data() + (row * (row + 1) / 2 + column) * tile_size * tile_size;
  }
  void pack(const CovarianceStep& step);
  template <class Work>
  void run_parts(const Work& work);

  /// Keeps its memory when passes project now few, now many rows.
  using AlignedValues = std::vector<double, Eigen::aligned_allocator<double>>;

  std::unique_ptr<WorkerPool> pool_;
  Eigen::Index tiles_ = 0;
  std::vector<Eigen::Index> part_begin_;  ///< first tile row of each part, then the number of tile rows
  std::vector<AlignedValues> products_;   ///< P H of each part, tile by tile
  struct {
    Eigen::Index terms = 0, projected = 0, stride = 0;
    AlignedValues values;
  } packed_;
  Eigen::MatrixXd moved_;  ///< A J
  Eigen::VectorXd values_;
};

}  // namespace kalfem
