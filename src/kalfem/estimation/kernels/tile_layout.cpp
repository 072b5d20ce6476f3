// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/kernels/tile_layout.hpp"

#include <algorithm>
#include <map>
#include <numeric>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

// States that A joins form groups; a group must stay within one tile. Groups are placed largest first, each at the
// first free slots of the right size ("first fit, decreasing"), pairs at even slots so that partners are neighbours.
// Most tiles then hold pairs only and move by two vectors, A's diagonal and its entries towards the partner; a tile
// with a larger group keeps its full 8 x 8 block.
/// States joined by entries of A, in either direction; ascending within each group, groups by their first state.
std::vector<std::vector<Index>> joined_states(const MatrixXd& A) {
  std::vector<Index> root(static_cast<std::size_t>(A.rows()));
  std::iota(root.begin(), root.end(), Index{0});
  const auto find = [&](Index i) {
    while (root[static_cast<std::size_t>(i)] != i) i = root[static_cast<std::size_t>(i)];
    return i;
  };
  for (Index j = 0; j < A.cols(); ++j)
    for (Index i = 0; i < A.rows(); ++i)
      if (i != j && A(i, j) != 0.0) {
        const auto [first, second] = std::minmax({find(i), find(j)});
        root[static_cast<std::size_t>(second)] = first;
      }
  std::map<Index, std::vector<Index>> groups;
  for (Index i = 0; i < A.rows(); ++i) groups[find(i)].push_back(i);
  std::vector<std::vector<Index>> result;
  for (auto& [first, group] : groups) result.push_back(std::move(group));
  return result;
}

/// Slots taken so far, tile by tile.
class Shelf {
public:
  /// First slot of `size` free ones in a row within one tile, pairs at even slots; a new tile where there are none.
  Index take(Index size) {
    const Index step = size == 1 ? 1 : 2;
    for (Index tile = first_open(); tile < tiles(); ++tile)
      for (Index offset = 0; offset + size <= tile_size; offset += step)
        if (const Index slot = tile * tile_size + offset; free(slot, size)) return mark(slot, size);
    taken_.resize(taken_.size() + tile_size, false);
    return mark((tiles() - 1) * tile_size, size);
  }
  [[nodiscard]] Index tiles() const { return static_cast<Index>(taken_.size()) / tile_size; }

private:
  /// Tiles before it are full: every search may start there.
  Index first_open() {
    while (open_ < tiles() && free_count(open_) == 0) ++open_;
    return open_;
  }
  [[nodiscard]] Index free_count(Index tile) const {
    return std::count(taken_.begin() + tile * tile_size, taken_.begin() + (tile + 1) * tile_size, false);
  }
  [[nodiscard]] bool free(Index slot, Index size) const {
    return std::none_of(taken_.begin() + slot, taken_.begin() + slot + size, [](bool taken) { return taken; });
  }
  Index mark(Index slot, Index size) {
    std::fill_n(taken_.begin() + slot, size, true);
    return slot;
  }
  std::vector<bool> taken_;
  Index open_ = 0;
};

}  // namespace

std::optional<TileLayout> tile_layout(const MatrixXd& A) {
  auto groups = joined_states(A);
  std::ranges::stable_sort(groups, [](const auto& a, const auto& b) { return a.size() > b.size(); });
  if (!groups.empty() && static_cast<Index>(groups.front().size()) > tile_size) return std::nullopt;
  TileLayout layout{std::vector<Index>(static_cast<std::size_t>(A.rows())), 0};
  Shelf shelf;
  for (const auto& group : groups) {
    Index slot = shelf.take(static_cast<Index>(group.size()));
    for (const Index state : group) layout.slot[static_cast<std::size_t>(state)] = slot++;
  }
  layout.tiles = shelf.tiles();
  return layout;
}

MatrixXd TileLayout::placed(const MatrixXd& states) const {
  MatrixXd result = MatrixXd::Zero(slots(), states.cols());
  for (Index i = 0; i < states.rows(); ++i) result.row(slot[static_cast<std::size_t>(i)]) = states.row(i);
  return result;
}

TiledPropagator::TiledPropagator(const MatrixXd& A, const TileLayout& layout)
    : own(Eigen::VectorXd::Zero(layout.slots())),
      other(Eigen::VectorXd::Zero(layout.slots())),
      full_place(static_cast<std::size_t>(layout.tiles), -1) {
  MatrixXd tiles = MatrixXd::Zero(layout.slots(), tile_size);  // diagonal tiles on top of each other
  for (Index j = 0; j < A.cols(); ++j)
    for (Index i = 0; i < A.rows(); ++i)
      if (A(i, j) != 0.0)
        tiles(layout.slot[static_cast<std::size_t>(i)], layout.slot[static_cast<std::size_t>(j)] % tile_size) = A(i, j);
  for (Index slot = 0; slot < layout.slots(); ++slot) {
    const Index column = slot % tile_size, partner = column ^ 1;
    own[slot] = tiles(slot, column);
    other[slot] = tiles(slot, partner);
    const auto row = tiles.row(slot).cwiseAbs();
    Index& place = full_place[static_cast<std::size_t>(slot / tile_size)];
    if (place >= 0 || row.sum() == std::abs(own[slot]) + std::abs(other[slot])) continue;
    place = full.size();
    full.conservativeResize(place + tile_size * tile_size);
    full.tail(tile_size * tile_size) = tiles.middleRows(slot - column, tile_size).reshaped();
  }
}

void TiledPropagator::apply(const MatrixXd& x, MatrixXd& y) const {
  y.resize(x.rows(), x.cols());
  for (Index column = 0; column < x.cols(); ++column)
    kernels().propagate(view(), x.rows() / tile_size, x.col(column).data(), y.col(column).data());
}

}  // namespace kalfem
