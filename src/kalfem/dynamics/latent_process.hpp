// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// An unknown signal as a stationary Gaussian process with the Matern covariance of smoothness nu = p - 1/2,
///     (d/dt + lambda)^p r = w,     lambda = sqrt(2 nu) / correlation_time,
/// or, with an infinite correlation time and p = 1, a random walk r' = w. Its states are [r; r'; ...], p of them; it
/// has p - 1 derivatives. p = 1 is the first-order Gauss-Markov process. Hartikainen and Sarkka, Kalman filtering and
/// smoothing solutions to temporal Gaussian process regression models, MLSP 2010 [HS10].
struct LatentProcess {
  int order = 1;                  ///< p = 1, 2, 3 for Matern 1/2, 3/2, 5/2
  double correlation_time = 1.0;  ///< [s], > 0; infinite only with p = 1

  [[nodiscard]] double rate() const;  ///< lambda [1/s], 0 for a random walk
  /// Last row of the companion matrix: r^(p) = feedback [r; r'; ...] + w.
  [[nodiscard]] Eigen::RowVectorXd feedback() const;
  /// Square root of the density of w for the stationary standard deviation `deviation` of r [its unit / s^(p - 1/2)].
  /// Not for a random walk, whose density is stated as such.
  [[nodiscard]] double density(double deviation) const;
  /// Stationary covariance of the states, p x p; for a random walk that of its start, deviation^2.
  [[nodiscard]] Eigen::MatrixXd covariance(double deviation) const;
};

}  // namespace kalfem
