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

/// Covariance of the past r_{k-1}, r_{k-2}, ..., whose block i, j is R_{j-i} of the references. `at(lag)` gives the
/// correlations of all channels with the references.
template <class AtLag>
MatrixXd block_toeplitz(Index block_rows, const std::vector<Index>& references, const VectorXd& reference_scale,
                        const AtLag& at) {
  const auto count = std::ssize(references);
  MatrixXd T(count * block_rows, count * block_rows);
  for (Index lag = 0; lag < block_rows; ++lag) {
    const MatrixXd all = at(lag);
    MatrixXd R = reference_scale.cwiseInverse().asDiagonal() * all(references, Eigen::all) *
                 reference_scale.cwiseInverse().asDiagonal();
    if (lag == 0) R = MatrixXd(0.5 * (R + R.transpose()));
    for (Index i = 0; i + lag < block_rows; ++i) {
      T.block(i * count, (i + lag) * count, count, count) = R;
      T.block((i + lag) * count, i * count, count, count) = R.transpose();
    }
  }
  return T;
}

/// B with B B^T = T^-1 over the combinations of the past that move: n x as many.
MatrixXd inverse_root(const MatrixXd& T) {
  constexpr double still = 1e-8;  ///< variance, as a part of the largest, that rounding and a record's ends make
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(T);
  const VectorXd& values = eigen.eigenvalues();
  const Index moving = (values.array() > still * values.tail(1).value()).count();
  return eigen.eigenvectors().rightCols(moving) * values.tail(moving).cwiseSqrt().cwiseInverse().asDiagonal();
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

// With B B^T = T^-1, dB = -1/2 B B^T dT B is a change of B that keeps this, and any other turns V alone. So
//   U^T d(H B) V_1 = U^T dH W - 1/2 S (B V)^T dT W,   V^T d(H B)^T U_1 = (B V)^T (dH^T U_1 - 1/2 dT W S_1),   W = B
//   V_1.
Subspace make_subspace(const OutputCorrelations& correlations, SubspaceMethod method, Index block_rows, Index max_order,
                       const VectorXd& scale, const std::vector<Index>& references, int threads) {
  const VectorXd reference_scale = scale(references);
  Subspace made{.channels = scale.size(),
                .block_rows = block_rows,
                .blocks = static_cast<Index>(correlations.deviations.size()),
                .reference_rows = references,
                .left = {},
                .values = {},
                .right = {},
                .first_lags = {},
                .forward = {},
                .reverse = {}};
  const bool by_data = method == SubspaceMethod::data;
  const auto mean_at = [&](Index lag) { return correlations.at(lag); };
  const MatrixXd H = block_hankel(block_rows, scale, reference_scale, mean_at);
  const MatrixXd B =
      by_data ? inverse_root(block_toeplitz(block_rows, references, reference_scale, mean_at)) : MatrixXd();
  const Eigen::BDCSVD<MatrixXd> svd(by_data ? MatrixXd(H * B) : H, Eigen::ComputeFullU | Eigen::ComputeFullV);
  made.left = svd.matrixU();
  made.values = svd.singularValues();
  made.right = svd.matrixV();
  made.first_lags = made.left.transpose() * H.leftCols(made.references());
  const MatrixXd BV = by_data ? MatrixXd(B * made.right) : made.right;
  max_order = std::min(max_order, made.columns() - made.columns() % 2);
  const MatrixXd W = BV.leftCols(max_order), U1 = made.left.leftCols(max_order);
  const Index m = made.rows(), n = made.columns(), both = made.values.size();
  made.forward.resize(made.blocks * m, max_order);
  made.reverse.resize(made.blocks * n, max_order);
  for_each_index(correlations.deviations.size(), threads, [&](std::size_t block) {
    stop_if_asked();
    const auto k = static_cast<Index>(block);
    const auto deviation_at = [&](Index lag) { return correlations.deviation(block, lag); };
    const MatrixXd dH = block_hankel(block_rows, scale, reference_scale, deviation_at);
    auto forward = made.forward.middleRows(k * m, m), reverse = made.reverse.middleRows(k * n, n);
    forward.noalias() = made.left.transpose() * (dH * W);
    reverse.noalias() = BV.transpose() * (dH.transpose() * U1);
    if (!by_data) return;
    const MatrixXd weighed =
        0.5 * BV.transpose() * (block_toeplitz(block_rows, references, reference_scale, deviation_at) * W);
    forward.topRows(both) -= made.values.asDiagonal() * weighed.topRows(both);
    reverse -= weighed * made.values.head(max_order).asDiagonal();
  });
  return made;
}

}  // namespace kalfem
