// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "kalfem/identification/filter_likelihood.hpp"

namespace kalfem {

struct FisherInformationOptions {
  double relative_step = 1e-3;  ///< of a central difference, to |theta_i|, or to `scale_i` where that is given
  Eigen::VectorXd scale = {};   ///< one per parameter [its unit]; needed where a value is zero
  int threads = 0;              ///< 0: one per processor; results do not depend on it
};

/// Fisher information of the named parameters along a record (Harvey 1989, section 3.4.5),
///     I_ij = sum_k [1/2 tr(S_k^-1 dS_k/di S_k^-1 dS_k/dj) + (dv_k/di)^T S_k^-1 (dv_k/dj)],
/// with the derivatives of the innovations v and their covariances S by central differences of filter passes in one
/// model. Two passes a parameter and one more. [1/(unit_i unit_j)], symmetric. Empty where a pass fails. Its mean over
/// records is the expected negative Hessian of the log-likelihood. Throws InvalidInput where a step is not positive or
/// sizes do not fit.
std::optional<Eigen::MatrixXd> fisher_information(const FilterLikelihood& likelihood, const Eigen::VectorXd& theta,
                                                  const FisherInformationOptions& options = {});

/// The step of the central difference of each parameter [its unit]. Adds an issue where sizes do not fit, which leaves
/// it empty, and for every parameter whose value is not finite or whose step would not be positive.
Eigen::VectorXd difference_steps(const std::vector<std::string>& names, const Eigen::VectorXd& theta,
                                 const FisherInformationOptions& options, IssueList& issues);

}  // namespace kalfem
