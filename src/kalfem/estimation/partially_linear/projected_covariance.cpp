#include "kalfem/estimation/partially_linear/projected_covariance.hpp"

#include <algorithm>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double same = 1e-12;  ///< relative difference of rows that rounding alone parts

}  // namespace

std::size_t ProjectedCovariance::add(const MatrixXd& rows, const TileLayout& layout) {
  const MatrixXd placed = layout.placed(rows.transpose());
  auto& places = matrices_.emplace_back();
  for (Index row = 0; row < placed.cols(); ++row) places.push_back(find_or_add(placed.col(row)));
  return matrices_.size() - 1;
}

ProjectedCovariance::Place ProjectedCovariance::find_or_add(const VectorXd& row) {
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

void ProjectedCovariance::find_followers(const TiledPropagator& transposed) {
  const Index count = dense_.cols();
  MatrixXd moved;
  transposed.apply(dense_, moved);
  std::vector<Index> leader(static_cast<std::size_t>(count), -1);
  const auto is_follower = [&](Index row) { return leader[static_cast<std::size_t>(row)] >= 0; };
  for (Index h = 0; h < count; ++h)
    for (Index g = 0; g < count && !is_follower(h); ++g)
      if (g != h && !is_follower(g) && (moved.col(h) - dense_.col(g)).norm() <= same * dense_.col(g).norm())
        if (std::ranges::find(leader, h) == leader.end()) leader[static_cast<std::size_t>(h)] = g;

  order_.assign(static_cast<std::size_t>(count), 0);
  std::vector<Index> sorted;
  for (const bool followers : {false, true})
    for (Index row = 0; row < count; ++row)
      if (is_follower(row) == followers) {
        order_[static_cast<std::size_t>(row)] = static_cast<Index>(sorted.size());
        sorted.push_back(row);
      }
  followed_.clear();
  for (const Index row : sorted)
    if (is_follower(row)) followed_.push_back(order_[static_cast<std::size_t>(leader[static_cast<std::size_t>(row)])]);
  dense_ = MatrixXd(dense_(Eigen::all, sorted));
  followers_ = dense_.rightCols(static_cast<Index>(followed_.size()));
  leaders_ = dense_.leftCols(count - followers_.cols());
}

std::vector<Index> ProjectedCovariance::places(std::size_t matrix) const {
  std::vector<Index> result;
  for (const auto& place : matrices_[matrix])
    result.push_back(place.single ? dense_.cols() + place.number : order_[static_cast<std::size_t>(place.number)]);
  return result;
}

}  // namespace kalfem
