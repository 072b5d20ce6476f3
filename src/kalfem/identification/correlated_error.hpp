// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>

namespace kalfem {

/// The error of a simulated channel: exponentially correlated, r_k = phi r_k-1 + e_k, phi = exp(-dt /
/// correlation_time).
struct CorrelatedError {
  double correlation_time = 0.0;  ///< [s]; 0: independent samples
  /// Stationary, in the unit of the series; empty: profiled, its most likely value.
  std::optional<double> deviation = {};
};

/// ln p of a series whose error is a stationary Gaussian process of first order, in O(samples): with e_1 = r_1 and
/// e_k = (r_k - phi r_k-1) / sqrt(1 - phi^2),
///     ln p = sum_k ln N(e_k; 0, s^2) - (N - 1)/2 ln(1 - phi^2).
/// Missing samples (NaN) lengthen the step: phi^gap. Of a profiled deviation, s^2 = sum_k e_k^2 / N: then infinity for
/// a series of zeros. -infinity where nothing was measured or a value is infinite. `interval` of the samples [s].
/// Throws InvalidInput where the interval is not positive, the correlation time negative, or the deviation not
/// positive.
double log_density_of_correlated_series(const Eigen::Ref<const Eigen::VectorXd>& series, double interval,
                                        const CorrelatedError& error);

}  // namespace kalfem
