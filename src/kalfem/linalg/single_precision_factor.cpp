// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/single_precision_factor.hpp"

#include <algorithm>
#include <utility>
#include "kalfem/linalg/large_pages.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::MatrixXf;
using Eigen::VectorXd;

// Every supernode [L_s; B_s], its own columns above, is kept as [L_s^-1; B_s L_s^-1] (partitioned inverse [APS93]): one
// product a supernode forwards, one back, in the place of a small triangular solution and a product.
SinglePrecisionFactor::SinglePrecisionFactor(Supernodes supernodes, std::span<const double> values)
    : supernodes_(std::move(supernodes)),
      values_(values.size()),
      permuted_(static_cast<Index>(supernodes_.order.size())) {
  Index tallest = 0;
  for (std::size_t s = 0; s < count(); ++s) {
    const auto [first, width, height, start] = shape(s);
    const Eigen::Map<const MatrixXd> panel(values.data() + start, height, width);
    MatrixXd inverse = MatrixXd::Identity(width, width);
    panel.topRows(width).triangularView<Eigen::Lower>().solveInPlace(inverse);
    Eigen::Map<MatrixXf> kept(values_.data() + start, height, width);
    kept.topRows(width) = inverse.cast<float>();
    kept.bottomRows(height - width) = (panel.bottomRows(height - width) * inverse).cast<float>();
    tallest = std::max(tallest, height);
  }
  panel_rows_.resize(tallest);
  move_to_large_pages(values_);
}

SinglePrecisionFactor::Shape SinglePrecisionFactor::shape(std::size_t s) const {
  const auto& [columns, row_starts, value_starts, rows, order] = supernodes_;
  return {columns[s], columns[s + 1] - columns[s], row_starts[s + 1] - row_starts[s], value_starts[s]};
}

// L y = P b from the first supernode to the last, L^T P x = y back again. The right-hand side is scaled to entries up
// to 1, so that single precision can hold it whatever its units.
void SinglePrecisionFactor::solve(const VectorXd& right_side, VectorXd& solution) {
  const auto& order = supernodes_.order;
  const double size = right_side.size() > 0 ? right_side.cwiseAbs().maxCoeff() : 0.0;
  const double scale = size > 0.0 ? size : 1.0;
  for (Index j = 0; j < permuted_.size(); ++j)
    permuted_[j] = static_cast<float>(right_side[order[static_cast<std::size_t>(j)]] / scale);
  for (std::size_t s = 0; s < count(); ++s) {
    const auto [first, width, height, start] = shape(s);
    const Eigen::Map<const MatrixXf> panel(values_.data() + start, height, width);
    const std::int64_t* below = supernodes_.rows.data() + supernodes_.row_starts[s] + width;
    auto image = panel_rows_.head(height);
    image.noalias() = panel * permuted_.segment(first, width);
    permuted_.segment(first, width) = image.head(width);
    for (Index i = 0; i < height - width; ++i) permuted_[below[i]] -= image[width + i];
  }
  for (std::size_t s = count(); s-- > 0;) {
    const auto [first, width, height, start] = shape(s);
    const Eigen::Map<const MatrixXf> panel(values_.data() + start, height, width);
    const std::int64_t* below = supernodes_.rows.data() + supernodes_.row_starts[s] + width;
    auto known = panel_rows_.head(height);
    known.head(width) = permuted_.segment(first, width);
    for (Index i = 0; i < height - width; ++i) known[width + i] = -permuted_[below[i]];
    permuted_.segment(first, width).noalias() = panel.transpose() * known;
  }
  solution.resize(right_side.size());
  for (Index j = 0; j < permuted_.size(); ++j)
    solution[order[static_cast<std::size_t>(j)]] = scale * static_cast<double>(permuted_[j]);
}

double SinglePrecisionFactor::bytes() const { return 4.0 * static_cast<double>(values_.size()); }

}  // namespace kalfem
