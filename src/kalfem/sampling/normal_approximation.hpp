// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// Mean and covariance of a posterior in the standard normal space z of the prior.
struct NormalApproximation {
  Eigen::VectorXd mean;        ///< p
  Eigen::MatrixXd covariance;  ///< p x p, positive definite
};

}  // namespace kalfem
