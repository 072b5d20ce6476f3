// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// Modal assurance criterion of two complex shapes, |a^H b|^2 / (a^H a b^H b) [All03]; 0 where one does not move.
double mac(const Eigen::VectorXcd& one, const Eigen::VectorXcd& other);

/// Modal phase collinearity: with the covariance of real and imaginary parts and its eigenvalues l_1 >= l_2,
/// ((l_1 - l_2) / (l_1 + l_2))^2; 1 for a shape of one phase, 0 for one that turns [PES93].
double phase_collinearity(const Eigen::VectorXcd& shape);

}  // namespace kalfem
