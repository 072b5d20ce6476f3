// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// The part of a posterior about one of its maxima.
struct PosteriorMode {
  double weight = 1.0;              ///< of all modes' sum [-]
  Eigen::VectorXd peak;             ///< theta at the maximum, p
  Eigen::VectorXd mean, deviation;  ///< of theta in this part, p
};

/// Parts below this weight are not told as modes.
inline constexpr double least_mode_weight = 0.01;

}  // namespace kalfem
