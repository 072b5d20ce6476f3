// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "kalfem/updating/parameter_statistics.hpp"

namespace kalfem {

/// What numbers c that an updating holds fixed, each known to a standard deviation sigma_i, add to its parameters.
struct Considered {
  Eigen::MatrixXd shift;       ///< d theta / d c, parameters x numbers
  Eigen::MatrixXd by_number;   ///< deviation that each number adds, |d theta / d c_i| sigma_i, parameters x numbers
  Eigen::VectorXd deviations;  ///< of all numbers together, by squares
  Eigen::VectorXd allowed;     ///< the most likely change of each number within what is stated
  Eigen::VectorXd residual;    ///< r with these changes, the parameters following
};

/// With the residual linear about its minimum theta, J = dr/dtheta, C = dr/dc and the priors' P,
///     d theta / d c = -H^-1 J^T C,   H = J^T J + P   (consider parameters, Schmidt 1966),
///     D = C + J d theta / d c,   allowed = -(D^T D + S^-1)^-1 D^T r,   S = diag(sigma^2),
/// and r + D allowed in place of r judges the fit: a residual within what is stated of the numbers is no misfit.
/// Parameters that are held, at a bound or undetermined do not move. `by_numbers`: C, rows x numbers; `sigma`: > 0.
Considered consider(const std::vector<UpdatingParameter>& parameters, const ParameterStatistics& statistics,
                    const ResidualValue& value, const Eigen::MatrixXd& by_numbers, const Eigen::VectorXd& sigma);

}  // namespace kalfem
