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

/// Climbs from `start` by BFGS to a maximum, or into the reach of one of the `known` peaks, which it then returns. Its
/// first steps are those of unit deviations, or shorter where the density is curved more. Throws Interrupted.
Peak climb(const LogDensity& log_density, const Eigen::VectorXd& start, const LaplaceOptions& options,
           const std::vector<Peak>& known = {});

/// The maxima that searches ended at, and how many of these began at samples of the prior.
struct PeakSearch {
  std::vector<Peak> peaks;  ///< the highest first
  int prior_starts = 0;     ///< that led to a peak, to one with too little mass, or are impossible
};

/// Climbs `log_density` over z by BFGS from the prior's median or the start, and from `random_starts` samples of the
/// prior. With `search_likelihoods` further samples of the prior follow until 60 in a row have ended at known peaks, or
/// these likelihoods are used. A search that comes near a known peak, at the height of the parabola about it, ends
/// there. Two ends are one peak unless they lie more than one deviation apart and the density between them falls below
/// the lower one by half its logarithm's unit. Peaks with less than a millionth of the estimated mass are left out.
/// Throws InvalidInput where the start does not fit or no start has a likelihood, and Interrupted.
PeakSearch find_peaks(const LogDensity& log_density, const JointPrior& prior, const LaplaceOptions& options);

/// What `starts` searches from samples of the prior exclude with 95 %: maxima to which more than this share of the
/// prior leads, 1 - 0.05^(1 / n), about 3 / n; 1 without starts. [-]
double unseen_share(int starts);

}  // namespace kalfem
