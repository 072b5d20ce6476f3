// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/white_innovations.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

/// S_k of the channels in use, and 1 for the others. Without the covariances of a run with many channels these are
/// taken for independent.
MatrixXd covariance_at(const EstimationResult& result, const Eigen::MatrixXi& used, Index k) {
  const Index l = used.rows();
  const auto& triangle = result.innovation_covariance;
  MatrixXd S = MatrixXd::Identity(l, l);
  for (Index i = 0; i < l; ++i) {
    if (used(i, k) == 0) continue;
    const double deviation = result.innovation_deviation(i, k);
    S(i, i) = deviation * deviation;
    for (Index j = 0; j < i && triangle.size() > 0; ++j)
      if (used(j, k) != 0) S(i, j) = S(j, i) = triangle(i * (i + 1) / 2 + j, k);
  }
  return S;
}

}  // namespace

WhiteInnovations::WhiteInnovations(const EstimationResult& result) : used_(used_samples(result)) {
  factors_.reserve(static_cast<std::size_t>(used_.cols()));
  for (Index k = 0; k < used_.cols(); ++k) factors_.emplace_back(covariance_at(result, used_, k).llt().matrixL());
}

MatrixXd WhiteInnovations::operator()(const MatrixXd& values) const {
  MatrixXd white = (used_.array() != 0).select(values, 0.0);
  for (Index k = 0; k < white.cols(); ++k) {
    auto column = white.col(k);
    factors_[static_cast<std::size_t>(k)].triangularView<Eigen::Lower>().solveInPlace(column);
  }
  return white;
}

}  // namespace kalfem
