// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "kalfem/statistics/robust_covariance.hpp"

namespace kalfem {

/// ln p(y_k | y_1 .. y_{k-1}; psi) of every sample at values psi of the parameters; nothing where the model cannot be
/// evaluated there. Called from several threads at once.
using LogDensities = std::function<std::optional<Eigen::VectorXd>(const Eigen::VectorXd& psi)>;

/// A parameter of a likelihood, with its normal prior.
struct LikelihoodParameter {
  double start = 0.0;
  double prior_mean = 0.0;
  double prior_deviation = std::numeric_limits<double>::infinity();  ///< infinite: there is no prior
  double step = 1e-3;                                                ///< of the central differences
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
};

struct LikelihoodOptions {
  int max_iterations = 30;
  double decrement = 1e-4;  ///< the search ends where a further step would raise the log-likelihood by less
  int threads = 1;          ///< that evaluate log-densities side by side
};

struct MaximumLikelihood {
  Eigen::VectorXd estimate;
  double log_likelihood = -std::numeric_limits<double>::infinity();  ///< of the data and the prior
  Eigen::MatrixXd covariance;                                        ///< inverse of the observed information
  RobustCovariance robust;                                           ///< where the model is not exact
  bool converged = false;
  int evaluations = 0;
};

/// Maximises sum_k ln p(y_k; psi) + ln p(psi) by Newton's method with central differences, in a trust region. The
/// observed information, the negative second derivative at the estimate, gives `covariance`; with the scores, the first
/// derivatives of each sample, it gives `robust` (robust_covariance()). Where the curvature has the wrong sign, its
/// size counts. An iteration over p parameters takes 2 p + 2 evaluations, the last one p (p + 1) + 1. Nothing where the
/// start cannot be evaluated.
std::optional<MaximumLikelihood> maximise_likelihood(const LogDensities& log_densities,
                                                     const std::vector<LikelihoodParameter>& parameters,
                                                     const LikelihoodOptions& options = {});

}  // namespace kalfem
