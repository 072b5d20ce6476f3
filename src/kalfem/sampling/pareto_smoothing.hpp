// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// Generalised Pareto distribution of x >= 0: P(X > x) = (1 + k x / sigma)^(-1/k), exponential for k = 0. Moments of
/// order 1/k and above are infinite where k > 0.
struct GeneralisedPareto {
  double shape = 0.0;  ///< k
  double scale = 1.0;  ///< sigma > 0

  [[nodiscard]] double quantile(double probability) const;
};

/// Fit to at least five positive values in ascending order by the quasi-Bayesian estimator of Zhang and Stephens (2009,
/// Technometrics 51, 316-325), which needs no iteration.
GeneralisedPareto fit_generalised_pareto(const Eigen::Ref<const Eigen::VectorXd>& sorted);

struct SmoothedWeights {
  Eigen::VectorXd log_weights;  ///< as given, but the largest replaced; not normalised
  /// k-hat of the largest weights, drawn towards 0.5 as by ten observations. Infinite where fewer than five weights
  /// differ from zero and from the least of them; zero where all are alike.
  double k_hat = 0.0;
};

/// Pareto smoothed importance sampling (Vehtari, Simpson, Gelman, Yao and Gabry 2024, JMLR 25(72), 1-58): a generalised
/// Pareto distribution is fitted to the M = min(S / 5, 3 sqrt(S)) largest of S weights above the next one, and these
/// are replaced by its quantiles (j - 1/2) / M, j = 1 ... M, in their order, but by none above the largest weight.
/// `log_weights`: S logarithms, -infinity for zero.
SmoothedWeights smooth_weights(const Eigen::VectorXd& log_weights);

/// k-hat above which S smoothed weights give no reliable mean: min(1 - 1 / log10(S), 0.7), the same source.
double k_hat_limit(Eigen::Index samples);

}  // namespace kalfem
