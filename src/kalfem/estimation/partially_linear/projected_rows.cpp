// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/partially_linear/projected_rows.hpp"

#include <algorithm>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double same = 1e-12;  ///< relative difference of rows that rounding alone parts

/// For each row h the row g = h A, or -1. A row that is itself propagated, or that others follow from, cannot serve:
/// the product with g must be at hand before that with h is formed.
std::vector<Index> sources_of(const MatrixXd& rows, const TiledPropagator& transposed) {
  const Index count = rows.cols();
  MatrixXd moved;
  transposed.apply(rows, moved);
  std::vector<Index> source(static_cast<std::size_t>(count), -1);
  const auto is_propagated = [&](Index row) { return source[static_cast<std::size_t>(row)] >= 0; };
  for (Index h = 0; h < count; ++h)
    for (Index g = 0; g < count && !is_propagated(h); ++g)
      if (g != h && !is_propagated(g) && (moved.col(h) - rows.col(g)).norm() <= same * rows.col(g).norm())
        if (std::ranges::find(source, h) == source.end()) source[static_cast<std::size_t>(h)] = g;
  return source;
}

}  // namespace

std::size_t ProjectedRows::add(const MatrixXd& rows, const TileLayout& layout) {
  const MatrixXd placed = layout.placed(rows.transpose());
  auto& places = matrices_.emplace_back();
  for (Index row = 0; row < placed.cols(); ++row) places.push_back(find_or_add(placed.col(row)));
  return matrices_.size() - 1;
}

/// A row with a single 1 picks a state; any other is compared with those that are there.
ProjectedRows::Place ProjectedRows::find_or_add(const VectorXd& row) {
  Index slot = 0;
  if (row.size() > 0 && row.cwiseAbs().sum() == 1.0 && row.maxCoeff(&slot) == 1.0) {
    const auto found = std::ranges::find(picked_, slot);
    if (found == picked_.end()) picked_.push_back(slot);
    return {true, std::ranges::find(picked_, slot) - picked_.begin()};
  }
  for (Index column = 0; column < dense_.cols(); ++column)
    if (dense_.col(column) == row) return {false, column};
  dense_.conservativeResize(row.size(), dense_.cols() + 1);
  dense_.rightCols(1) = row;
  return {false, dense_.cols() - 1};
}

void ProjectedRows::find_propagated(const TiledPropagator& transposed) {
  const Index count = dense_.cols();
  const auto source = sources_of(dense_, transposed);
  const auto is_propagated = [&](Index row) { return source[static_cast<std::size_t>(row)] >= 0; };
  order_.assign(static_cast<std::size_t>(count), 0);
  std::vector<Index> sorted;  // direct rows first
  for (const bool propagated : {false, true})
    for (Index row = 0; row < count; ++row)
      if (is_propagated(row) == propagated) {
        order_[static_cast<std::size_t>(row)] = static_cast<Index>(sorted.size());
        sorted.push_back(row);
      }
  sources_.clear();
  for (const Index row : sorted)
    if (is_propagated(row)) {
      const Index g = source[static_cast<std::size_t>(row)];
      sources_.push_back(order_[static_cast<std::size_t>(g)]);
    }
  dense_ = MatrixXd(dense_(Eigen::all, sorted));
  propagated_ = dense_.rightCols(static_cast<Index>(sources_.size()));
  direct_ = dense_.leftCols(count - propagated_.cols());
}

std::vector<Index> ProjectedRows::places(std::size_t matrix) const {
  std::vector<Index> result;
  for (const auto& place : matrices_[matrix])
    result.push_back(place.picked ? dense_.cols() + place.number : order_[static_cast<std::size_t>(place.number)]);
  return result;
}

}  // namespace kalfem
