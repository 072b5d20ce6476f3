// SPDX-License-Identifier: Apache-2.0
#include "kalfem/dynamics/latent_process.hpp"

#include <cmath>

namespace kalfem {

double LatentProcess::rate() const {
  return std::isinf(correlation_time) ? 0.0 : std::sqrt(2.0 * order - 1.0) / correlation_time;
}

// Coefficients of (s + lambda)^p.
Eigen::RowVectorXd LatentProcess::feedback() const {
  Eigen::RowVectorXd row(order);
  double binomial = 1.0;
  for (int i = 0; i < order; ++i) {
    row[i] = -binomial * std::pow(rate(), order - i);
    binomial *= static_cast<double>(order - i) / static_cast<double>(i + 1);
  }
  return row;
}

// q = 2 sigma^2 sqrt(pi) lambda^(2 p - 1) Gamma(p) / Gamma(p - 1/2).
double LatentProcess::density(double deviation) const {
  const double ratio = order == 1 ? 2.0 : order == 2 ? 4.0 : 16.0 / 3.0;
  return deviation * std::sqrt(ratio * std::pow(rate(), 2 * order - 1));
}

Eigen::MatrixXd LatentProcess::covariance(double deviation) const {
  const double l = rate(), variance = deviation * deviation;
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(order, order);
  covariance(0, 0) = variance;
  if (order == 2) covariance(1, 1) = variance * l * l;
  if (order == 3) {
    covariance(1, 1) = variance * l * l / 3.0;
    covariance(0, 2) = covariance(2, 0) = -covariance(1, 1);
    covariance(2, 2) = variance * std::pow(l, 4);
  }
  return covariance;
}

}  // namespace kalfem
