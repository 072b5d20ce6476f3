// SPDX-License-Identifier: Apache-2.0
#include "kalfem/modal/subspace.hpp"

#include "kalfem/base/interruption.hpp"
#include "kalfem/base/parallel.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// `at(lag)` gives the correlations of a lag.
template <class AtLag>
MatrixXd block_hankel(Index block_rows, const VectorXd& scale, const VectorXd& reference_scale, const AtLag& at) {
  const Index channels = scale.size(), references = reference_scale.size();
  MatrixXd H(channels * block_rows, references * block_rows);
  for (Index lag = 1; lag < 2 * block_rows; ++lag) {
    const MatrixXd R = scale.cwiseInverse().asDiagonal() * at(lag) * reference_scale.cwiseInverse().asDiagonal();
    for (Index row = std::max<Index>(0, lag - block_rows); row < std::min(lag, block_rows); ++row)
      H.block(row * channels, (lag - 1 - row) * references, channels, references) = R;
  }
  return H;
}

}  // namespace

MatrixXd Subspace::deviations(Index order) const {
  const Index m = rows(), n = columns(), rest = m - order;
  const Index shared = std::max<Index>(0, std::min(m, n) - order);
  MatrixXd F(blocks * rest, order);
  for (Index j = 0; j < order; ++j) {
    Eigen::ArrayXd of_forward = Eigen::ArrayXd::Constant(rest, 1.0 / values[j]), of_reverse(shared),
                   turn = Eigen::ArrayXd::Zero(rest);
    for (Index i = 0; i < shared; ++i) {
      const double s = values[j], t = values[order + i], gap = std::max(s * s - t * t, 1e-14 * s * s);
      of_forward[i] = s / gap;
      of_reverse[i] = t / gap;
    }
    for (Index block = 0; block < blocks; ++block) {
      auto column = F.col(j).segment(block * rest, rest).array();
      column = forward.col(j).segment(block * m + order, rest).array() * of_forward;
      column.head(shared) += reverse.col(j).segment(block * n + order, shared).array() * of_reverse;
      turn += column.square();
    }
    turn = (1.0 + 4.0 * turn / static_cast<double>(blocks * blocks)).rsqrt();
    for (Index block = 0; block < blocks; ++block) F.col(j).segment(block * rest, rest).array() *= turn;
  }
  return F;
}

Subspace make_subspace(const OutputCorrelations& correlations, Index block_rows, Index max_order, const VectorXd& scale,
                       const std::vector<Index>& references, int threads) {
  const VectorXd reference_scale = scale(references);
  Subspace made{.channels = scale.size(),
                .block_rows = block_rows,
                .blocks = static_cast<Index>(correlations.deviations.size()),
                .reference_rows = references,
                .left = {},
                .values = {},
                .right = {},
                .forward = {},
                .reverse = {}};
  const MatrixXd H = block_hankel(block_rows, scale, reference_scale, [&](Index lag) { return correlations.at(lag); });
  const Eigen::BDCSVD<MatrixXd> svd(H, Eigen::ComputeFullU | Eigen::ComputeFullV);
  made.left = svd.matrixU();
  made.values = svd.singularValues();
  made.right = svd.matrixV();
  const Index m = made.rows(), n = made.columns();
  made.forward.resize(made.blocks * m, max_order);
  made.reverse.resize(made.blocks * n, max_order);
  for_each_index(correlations.deviations.size(), threads, [&](std::size_t block) {
    stop_if_asked();
    const auto k = static_cast<Index>(block);
    const MatrixXd dH =
        block_hankel(block_rows, scale, reference_scale, [&](Index lag) { return correlations.deviation(block, lag); });
    made.forward.middleRows(k * m, m).noalias() = made.left.transpose() * (dH * made.right.leftCols(max_order));
    made.reverse.middleRows(k * n, n).noalias() =
        made.right.transpose() * (dH.transpose() * made.left.leftCols(max_order));
  });
  return made;
}

}  // namespace kalfem
