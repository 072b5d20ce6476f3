// SPDX-License-Identifier: Apache-2.0
#include "kalfem/modal/block_covariance.hpp"

#include <algorithm>

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// sum_h w_h Gamma_h / n, made up for the mean that was taken off.
template <class Window>
MatrixXd windowed_sum(const MatrixXd& deviations, Index lags, const Window& window) {
  const Index n = deviations.cols();
  MatrixXd sum = deviations * deviations.transpose();
  double weights = 1.0;
  for (Index lag = 1; lag < std::min(lags, n); ++lag) {
    const double weight = window(lag);
    const MatrixXd product = deviations.leftCols(n - lag) * deviations.rightCols(n - lag).transpose();
    sum += weight * (product + product.transpose());
    weights += 2.0 * weight * static_cast<double>(n - lag) / static_cast<double>(n);
  }
  const double count = static_cast<double>(n);
  return sum / (count * count * std::max(0.1, 1.0 - weights / count));
}

}  // namespace

BlockCovariance block_covariance(const MatrixXd& deviations, Index memory) {
  const Index n = deviations.cols(), lags = 2 * memory;
  const auto trapezoid = [=](Index lag) {
    return std::min(1.0, 2.0 - static_cast<double>(lag) / static_cast<double>(memory));
  };
  const auto triangle = [=](Index lag) { return 1.0 - static_cast<double>(lag) / static_cast<double>(lags); };
  const MatrixXd flat = windowed_sum(deviations, lags, trapezoid), safe = windowed_sum(deviations, lags, triangle);
  double squares = 1.0;
  for (Index lag = 1; lag < lags; ++lag) squares += 2.0 * trapezoid(lag) * trapezoid(lag);
  VectorXd scale = VectorXd::Ones(flat.rows());
  for (Index i = 0; i < flat.rows(); ++i)
    if (safe(i, i) > 0.0) scale[i] = std::sqrt(std::max(0.5, flat(i, i) / safe(i, i)));
  return {scale.asDiagonal() * safe * scale.asDiagonal(), static_cast<double>(n) / squares};
}

}  // namespace kalfem
