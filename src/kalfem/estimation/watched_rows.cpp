#include "kalfem/estimation/watched_rows.hpp"

#include <algorithm>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::size_t WatchedRows::add(const MatrixXd& rows, const TileLayout& layout) {
  const MatrixXd placed = layout.placed(rows.transpose());
  auto& places = matrices_.emplace_back();
  for (Index row = 0; row < placed.cols(); ++row) places.push_back(find_or_add(placed.col(row)));
  return matrices_.size() - 1;
}

WatchedRows::Place WatchedRows::find_or_add(const VectorXd& row) {
  Index slot = 0;
  if (row.size() > 0 && row.cwiseAbs().sum() == 1.0 && row.maxCoeff(&slot) == 1.0) {
    const auto found = std::ranges::find(single_, slot);
    if (found == single_.end()) single_.push_back(slot);
    return {true, std::ranges::find(single_, slot) - single_.begin()};
  }
  for (Index column = 0; column < dense_.cols(); ++column)
    if (dense_.col(column) == row) return {false, column};
  dense_.conservativeResize(row.size(), dense_.cols() + 1);
  dense_.rightCols(1) = row;
  return {false, dense_.cols() - 1};
}

std::vector<Index> WatchedRows::places(std::size_t matrix) const {
  std::vector<Index> result;
  for (const auto& place : matrices_[matrix])
    result.push_back(place.single ? dense_.cols() + place.number : place.number);
  return result;
}

}  // namespace kalfem
