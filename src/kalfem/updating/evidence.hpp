// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/updating/residual.hpp"

namespace kalfem {

/// Logarithm of the evidence of an updating that ended at theta, by Laplace's method (MacKay 1992, Neural Computation
/// 4, 415-447): the probability of what was measured before the parameters are known,
///     ln Z = -(|r|^2 + |P (theta - theta_0)|^2) / 2 - ln det(H)^(1/2) - sum ln sigma,   H = J^T J + P^2,
/// P = diag(1 / sigma) of the priors' deviations. What the measurements' own deviations add is left out: it is the same
/// of all that is fitted to the same measurements. Every parameter has a prior; `value` has the Jacobian.
double log_evidence(const std::vector<UpdatingParameter>& parameters, const Eigen::VectorXd& theta,
                    const ResidualValue& value);

}  // namespace kalfem
