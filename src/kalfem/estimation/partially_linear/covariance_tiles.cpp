// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/partially_linear/covariance_tiles.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/estimation/covariance_factor.hpp"
#include "kalfem/estimation/kernels/kernel_set.hpp"
#include "kalfem/estimation/kernels/vector_lanes.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr Index divided_from = 48;  ///< tile rows, n = 384: a pass then takes many times what it costs to share it
constexpr int parts = 4;
constexpr double negligible = 1e-15;  ///< of the standard deviations' product: what rounding leaves of a zero

/// Tile rows that begin parts of about equally many tiles of the lower triangle.
std::vector<Index> equal_parts(Index tiles, int count) {
  std::vector<Index> begin;
  for (int part = 0; part < count; ++part)
    begin.push_back(static_cast<Index>(std::round(static_cast<double>(tiles) * std::sqrt(double(part) / count))));
  begin.push_back(tiles);
  return begin;
}

}  // namespace

SymmetricTiles::SymmetricTiles(const MatrixXd& matrix, const TileLayout& layout) {
  const MatrixXd rows = layout.placed(matrix), placed = layout.placed(rows.transpose());
  std::vector<double> kept;
  for (Index row = 0; row < layout.tiles; ++row)
    for (Index column = 0; column <= row; ++column) {
      const Eigen::Matrix<double, 8, 8> tile = placed.block<8, 8>(row * tile_size, column * tile_size);
      bool zero = true;
      for (Index j = 0; j < 8; ++j)
        for (Index i = 0; i < 8; ++i) {
          const Index a = row * tile_size + i, b = column * tile_size + j;
          zero = zero && std::abs(tile(i, j)) <= negligible * std::sqrt(placed(a, a) * placed(b, b));
        }
      place_.push_back(zero ? -1 : static_cast<Index>(kept.size()));
      if (!zero) kept.insert(kept.end(), tile.data(), tile.data() + tile.size());
    }
  values_ = Eigen::Map<const Eigen::VectorXd>(kept.data(), static_cast<Index>(kept.size()));
}

// One pass (docs/theory/partially-linear-ukf.md, "One pass over the covariance"):
//   1. pack(): the thin columns that meet in a tile, one behind the other in memory: -A J, W, U left; A J, U, W right;
//      then the rows H.
//   2. KernelSet::pass_over: for each tile of the lower triangle, load; widen the diagonal before a downdate; A_I T
//   A_J^T; add
//      the products of the packed columns and the tile of Q; store; add T H_J and, off the diagonal, T^T H_I.
//   3. Sums of the parts are added in a fixed order, so results do not depend on who computed which part.
CovarianceTiles::CovarianceTiles(int threads) : pool_(std::make_unique<WorkerPool>(std::clamp(threads, 1, parts))) {}

void CovarianceTiles::reset(const MatrixXd& covariance, const TileLayout& layout) {
  tiles_ = layout.tiles;
  part_begin_ = equal_parts(tiles_, tiles_ < divided_from ? 1 : parts);
  products_.resize(part_begin_.size() - 1);
  values_.resize(tiles_ * (tiles_ + 1) / 2 * tile_size * tile_size);
  const MatrixXd symmetric = covariance.selfadjointView<Eigen::Lower>();
  const MatrixXd rows = layout.placed(symmetric), placed = layout.placed(rows.transpose());
  for (Index row = 0; row < tiles_; ++row)
    for (Index column = 0; column <= row; ++column)
      Eigen::Map<Eigen::Matrix<double, 8, 8>>(tile(row, column)) =
          placed.block<8, 8>(row * tile_size, column * tile_size);
}

void CovarianceTiles::pass(const CovarianceStep& step, MatrixXd& product) {
  pack(step);
  const KernelPropagator propagator = step.propagator ? step.propagator->view() : KernelPropagator{};
  const KernelTiles noise = step.process_noise ? step.process_noise->view() : KernelTiles{};
  const TilePass pass{.terms = packed_.terms,
                      .projected = packed_.projected,
                      .stride = packed_.stride,
                      .packed = packed_.values.data(),
                      .propagator = step.propagator ? &propagator : nullptr,
                      .noise = step.process_noise ? &noise : nullptr,
                      .widening = step.downdate ? 1.0 + rounding_allowance : 1.0,
                      .values = values_.data()};
  run_parts([&](int part) {
    const auto index = static_cast<std::size_t>(part);
    products_[index].assign(static_cast<std::size_t>(tiles_ * packed_.projected * tile_size), 0.0);
    TilePass over = pass;
    over.begin = part_begin_[index], over.end = part_begin_[index + 1], over.product = products_[index].data();
    kernels().pass_over(over);
  });
  for (Index tile = 0; tile < tiles_; ++tile)
    for (Index c = 0; c < packed_.projected; ++c) {
      const Index place = (tile * packed_.projected + c) * tile_size;
      Lanes sum = load(products_[0].data() + place);
      for (std::size_t part = 1; part < products_.size(); ++part) sum += load(products_[part].data() + place);
      store(&product(tile * tile_size, c), sum);
    }
}

template <class Work>
void CovarianceTiles::run_parts(const Work& work) {
  if (products_.size() == 1)
    work(0);
  else
    pool_->run(static_cast<int>(products_.size()), work);
}

/// All thin columns that meet in a tile, one after the other for each tile: left and right factors of the low-rank
/// terms,
///     -(A J) (A J)^T + W U^T + U W^T,
/// and the projected rows.
void CovarianceTiles::pack(const CovarianceStep& step) {
  const auto columns = [](const MatrixXd* matrix) { return matrix ? matrix->cols() : 0; };
  const Index l = columns(step.downdate), p = columns(step.gain);
  packed_.terms = l + 2 * p;
  packed_.projected = columns(step.projected);
  packed_.stride = (2 * packed_.terms + packed_.projected) * tile_size;
  packed_.values.resize(static_cast<std::size_t>(tiles_ * packed_.stride));
  if (step.downdate && step.propagator) step.propagator->apply(*step.downdate, moved_);
  const MatrixXd* down = step.propagator ? &moved_ : step.downdate;
  for (Index tile = 0; tile < tiles_; ++tile) {
    double* left = packed_.values.data() + tile * packed_.stride;
    double* right = left + packed_.terms * tile_size;
    const auto add = [&](const Lanes& a, const Lanes& b) {
      store(left, a);
      store(right, b);
      left += tile_size;
      right += tile_size;
    };
    const auto entry = [&](const MatrixXd* matrix, Index c) { return load(&(*matrix)(tile * tile_size, c)); };
    for (Index c = 0; c < l; ++c) {
      const Lanes moved = load(&(*down)(tile * tile_size, c));
      add(-moved, moved);
    }
    for (Index c = 0; c < p; ++c) {
      add(entry(step.response, c), entry(step.gain, c));
      add(entry(step.gain, c), entry(step.response, c));
    }
    for (Index c = 0; c < packed_.projected; ++c) store(right + c * tile_size, entry(step.projected, c));
  }
}

void CovarianceTiles::column(Index slot, double* out) const {
  const Index at = slot / tile_size, offset = slot % tile_size;
  for (Index before = 0; before < at; ++before) {
    const double* values = tile(at, before) + offset;
    for (Index j = 0; j < tile_size; ++j) out[before * tile_size + j] = values[j * tile_size];
  }
  for (Index row = at; row < tiles_; ++row) store(out + row * tile_size, load(tile(row, at) + offset * tile_size));
}

double CovarianceTiles::entry(Index one, Index other) const {
  const auto [column, row] = std::minmax(one, other);
  return tile(row / tile_size, column / tile_size)[row % tile_size + (column % tile_size) * tile_size];
}

MatrixXd CovarianceTiles::matrix(const TileLayout& layout) const {
  const auto n = static_cast<Index>(layout.slot.size());
  MatrixXd result(n, n);
  for (Index j = 0; j < n; ++j)
    for (Index i = 0; i < n; ++i)
      result(i, j) = entry(layout.slot[static_cast<std::size_t>(i)], layout.slot[static_cast<std::size_t>(j)]);
  return result;
}

}  // namespace kalfem
