// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// A normal distribution; the covariance is symmetric positive semi-definite.
struct Gaussian {
  Eigen::VectorXd mean;        ///< n
  Eigen::MatrixXd covariance;  ///< n x n
};

}  // namespace kalfem
