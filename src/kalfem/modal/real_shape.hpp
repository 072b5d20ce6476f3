// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// A complex shape as a real one.
struct RealShape {
  Eigen::VectorXd values;      ///< real parts after the rotation; what is not a number stays so
  Eigen::MatrixXd covariance;  ///< of them; empty where that of the complex shape is not known
  double complexity = 0.0;     ///< |imaginary part| / |shape| after the rotation, in [0, 0.71]: 0 where all is in phase
};

/// The shape turned by exp(-i arg(phi^T phi) / 2), the phase at which its real part is largest: real and imaginary part
/// are then orthogonal, and MPC = (1 - 2 complexity^2)^2 (see phase_collinearity()). `covariance`: of real parts, then
/// imaginary ones, 2n x 2n, or empty; the rotation itself is taken as known, which costs a term of the order of the
/// complexity.
RealShape real_shape(const Eigen::VectorXcd& shape, const Eigen::MatrixXd& covariance = {});

}  // namespace kalfem
