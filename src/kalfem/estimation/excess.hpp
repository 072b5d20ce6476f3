// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// What constant unknowns that are less well known than a filter says add to other quantities y of it: the deviations
/// of B e, where e has the excess E = F F^T of the unknowns' covariance over the filter's, and
///     B = dy / dtheta = P_y,theta P_theta^-1
/// tells by how much y moves with them, given all that the filter saw (Friedland 1969, IEEE Trans. Automatic Control
/// 14, 359-367). `cross`: P_y,theta, quantities x c. `covariance`: P_theta, c x c. `factor`: F, c x any.
Eigen::VectorXd deviation_of_excess(const Eigen::Ref<const Eigen::MatrixXd>& cross,
                                    const Eigen::Ref<const Eigen::MatrixXd>& covariance,
                                    const Eigen::Ref<const Eigen::MatrixXd>& factor);

}  // namespace kalfem
