// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <limits>
#include <vector>

#include "kalfem/sampling/laplace.hpp"
#include "kalfem/sampling/log_posterior_differences.hpp"

namespace kalfem {

/// A maximum that the search found.
struct Peak {
  Eigen::VectorXd z;
  double value = -std::numeric_limits<double>::infinity();  ///< of the log-density
  Eigen::MatrixXd inverse;  ///< of the negative Hessian over z, approximately, positive definite
  bool converged = false;
};

/// Climbs `log_density` over z by BFGS from the prior's median or the start, and from `random_starts` samples of the
/// prior. Returns the highest peak, and after it the other converged ones that lie more than one deviation apart from
/// all before them. Throws InvalidInput where the start does not fit or no start has a likelihood, and Interrupted.
std::vector<Peak> find_peaks(const LogDensity& log_density, const JointPrior& prior, const LaplaceOptions& options);

}  // namespace kalfem
