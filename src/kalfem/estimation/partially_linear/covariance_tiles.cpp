// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/partially_linear/covariance_tiles.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/estimation/covariance_factor.hpp"
#include "kalfem/estimation/kernels/vector_lanes.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr Index divided_from = 48;  ///< tile rows, n = 384: a pass then takes many times what it costs to share it
constexpr int parts = 4;
constexpr double negligible = 1e-15;  ///< of the standard deviations' product: what rounding leaves of a zero

/// One tile in registers, column by column.
using Tile = Lanes[8];

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
    const Lanes column = load(left + c * tile_size);
    const double* row = right + c * tile_size;
#pragma GCC unroll 8
    for (int j = 0; j < 8; ++j) t[j] += column * row[j];
  }
}

/// T <- A_I T A_J^T with pairs.
[[gnu::always_inline]] inline void propagate_pairs(const TiledPropagator& a, Index row, Index column, Tile& t) {
  const double *own = &a.own[column * tile_size], *other = &a.other[column * tile_size];
#pragma GCC unroll 4
  for (int j = 0; j < 8; j += 2) {
    const Lanes first = t[j], second = t[j + 1];
    t[j] = first * own[j] + second * other[j];
    t[j + 1] = second * own[j + 1] + first * other[j + 1];
  }
  const Lanes left = load(&a.own[row * tile_size]), across = load(&a.other[row * tile_size]);
#pragma GCC unroll 8
  for (int j = 0; j < 8; ++j) t[j] = left * t[j] + across * swap_neighbours(t[j]);
}

using Map8 = Eigen::Map<Eigen::Matrix<double, 8, 8>, Eigen::Aligned64>;

/// The same where a tile of A has larger blocks.
[[gnu::noinline]] void propagate_full(const TiledPropagator& a, Index row, Index column, double* values) {
  const auto block = [&](Index tile) -> Eigen::Matrix<double, 8, 8> {
    if (const auto& full = a.full[static_cast<std::size_t>(tile)]) return *full;
    Eigen::Matrix<double, 8, 8> pairs = Eigen::Matrix<double, 8, 8>::Zero();
    for (Index i = 0; i < 8; ++i) {
      pairs(i, i) = a.own[tile * tile_size + i];
      pairs(i, i ^ 1) = a.other[tile * tile_size + i];
    }
    return pairs;
  };
  Map8 t(values);
  const Eigen::Matrix<double, 8, 8> moved = block(row) * t * block(column).transpose();
  t = moved;
}

/// Tile rows that begin parts of about equally many tiles of the lower triangle.
std::vector<Index> equal_parts(Index tiles, int count) {
  std::vector<Index> begin;
  for (int part = 0; part < count; ++part)
    begin.push_back(static_cast<Index>(std::round(static_cast<double>(tiles) * std::sqrt(double(part) / count))));
  begin.push_back(tiles);
  return begin;
}

/// Y_I += T H_J.
[[gnu::always_inline]] inline void multiply_tile(const Tile& t, Index columns, const double* h, double* y) {
  for (Index c = 0; c < columns; ++c) {
    const double* factor = h + c * tile_size;
    double* to = y + c * tile_size;
    const Lanes even = (t[0] * factor[0] + t[2] * factor[2]) + (t[4] * factor[4] + t[6] * factor[6]);
    const Lanes odd = (t[1] * factor[1] + t[3] * factor[3]) + (t[5] * factor[5] + t[7] * factor[7]);
    store(to, load(to) + (even + odd));
  }
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
//   2. pass_over(): for each tile of the lower triangle, load; widen the diagonal before a downdate; A_I T A_J^T; add
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
      Map8(tile(row, column)) = placed.block<8, 8>(row * tile_size, column * tile_size);
}

void CovarianceTiles::pass(const CovarianceStep& step, MatrixXd& product) {
  pack(step);
  run_parts([&](int part) {
    const auto index = static_cast<std::size_t>(part);
    products_[index].assign(static_cast<std::size_t>(tiles_ * packed_.projected * tile_size), 0.0);
    pass_over(part_begin_[index], part_begin_[index + 1], step, products_[index].data());
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
      Lanes moved = entry(step.downdate, c);
      if (step.propagator) {
        alignas(64) double values[tile_size];
        step.propagator->apply_to_tile(tile, &(*step.downdate)(tile * tile_size, c), values);
        moved = load(values);
      }
      add(-moved, moved);
    }
    for (Index c = 0; c < p; ++c) {
      add(entry(step.response, c), entry(step.gain, c));
      add(entry(step.gain, c), entry(step.response, c));
    }
    for (Index c = 0; c < packed_.projected; ++c) store(right + c * tile_size, entry(step.projected, c));
  }
}

void CovarianceTiles::pass_over(Index begin, Index end, const CovarianceStep& step, double* product) {
  const Index terms = packed_.terms, projected = packed_.projected;
  const auto full = [&](Index tile) { return step.propagator->full[static_cast<std::size_t>(tile)].has_value(); };
  for (Index row = begin; row < end; ++row) {
    const bool full_row = step.propagator && full(row);
    const double* of_row = packed_.values.data() + row * packed_.stride;
    for (Index column = 0; column <= row; ++column) {
      const double* of_column = packed_.values.data() + column * packed_.stride;
      double* values = tile(row, column);
      if (step.downdate && row == column)
        for (int i = 0; i < 8; ++i) values[9 * i] *= 1.0 + rounding_allowance;
      if (full_row || (step.propagator && full(column))) [[unlikely]]
        propagate_full(*step.propagator, row, column, values);
      Tile t;
      load_tile(values, t);
      if (step.propagator && !full_row && !full(column)) propagate_pairs(*step.propagator, row, column, t);
      add_products(terms, of_row, of_column + terms * tile_size, t);
      if (const double* noise = step.process_noise ? step.process_noise->tile(row, column) : nullptr) {
#pragma GCC unroll 8
        for (int i = 0; i < 8; ++i) t[i] += load(noise + i * 8);
      }
      Tile mirrored;
      transpose(t, mirrored);
      if (row == column) {
#pragma GCC unroll 8
        for (int i = 0; i < 8; ++i) t[i] = 0.5 * (t[i] + mirrored[i]);
      } else {
        multiply_tile(mirrored, projected, of_row + 2 * terms * tile_size, product + column * projected * tile_size);
      }
      store_tile(t, values);
      multiply_tile(t, projected, of_column + 2 * terms * tile_size, product + row * projected * tile_size);
    }
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
