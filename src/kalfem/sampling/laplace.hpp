// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/sampling/posterior.hpp"

namespace kalfem {

struct LaplaceOptions {
  int max_iterations = 100;
  double decrement = 1e-6;  ///< ends where a Newton step would raise the log-posterior by less
  int random_starts = 0;    ///< samples of the prior to start from, beside its median or `start`
  /// For searches from further samples of the prior, which end when none tells of another maximum; see find_peaks().
  long long search_likelihoods = 0;
  std::uint64_t seed = 1;
  std::optional<Eigen::VectorXd> start;  ///< theta
  int threads = 1;                       ///< that evaluate differences side by side; results do not depend on it
};

/// Normal approximation of the posterior about one maximum.
struct LaplaceMode {
  Eigen::VectorXd mode;         ///< theta that maximises p(data | theta) p(theta)
  double log_likelihood = 0.0;  ///< there
  double log_prior = 0.0;       ///< there
  Eigen::MatrixXd covariance;   ///< (-H)^-1 of the Hessian H of the log-posterior; empty unless H is negative definite
  std::optional<double> log_evidence;  ///< ln p(data | mode) + ln p(mode) + p/2 ln 2 pi - 1/2 ln det(-H)
};

/// About the highest maximum, with the others that were found.
struct LaplaceApproximation : LaplaceMode {
  std::vector<LaplaceMode> others;    ///< with a covariance, the heaviest first
  std::vector<std::string> warnings;  ///< why it may not hold, in words; empty: nothing speaks against it
  bool converged = false;
  int prior_starts = 0;  ///< searches from samples of the prior, see unseen_share()
  int evaluations = 0;

  /// One maximum describes the posterior.
  [[nodiscard]] bool usable() const {
    return converged && log_evidence.has_value() && warnings.empty() && others.empty();
  }
  /// ln of the sum of Z over all maxima; empty where that of the highest is.
  [[nodiscard]] std::optional<double> log_evidence_of_all() const;
};

/// Maximises the log-posterior by BFGS over the standard normals of the prior, where bounds are at infinity, then takes
/// the Hessian over theta by central differences with steps over which the log-posterior falls by about 0.01.
/// Warnings: not converged, the Hessian not negative definite, a bound within two deviations of the mode or on it.
/// Throws InvalidInput where no start has a likelihood, and Interrupted.
LaplaceApproximation laplace_approximation(const Posterior& posterior, const LaplaceOptions& options = {});

}  // namespace kalfem
