// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/estimation/gaussian.hpp"
#include "kalfem/estimation/process_model.hpp"
#include "kalfem/estimation/smoother/adjoint.hpp"

namespace kalfem {

/// x_s = x + P lambda, n.
Eigen::VectorXd smoothed_mean(const Gaussian& filtered, const Adjoint& adjoint);

/// R P_s R^T with P_s = P - P Lambda P, `rows`: R, r x n.
Eigen::MatrixXd smoothed_covariance(const Eigen::MatrixXd& rows, const Gaussian& filtered, const Adjoint& adjoint);

/// Mean and, where asked for, standard deviation of the outputs y = A x + G phi + b at the smoothed estimate,
///     mean(y) = A x_s + G mean(phi) + b,     P_yy = A P_s A^T + T G^T + G T^T,     T = A P_xphi + G P_phi / 2.
/// `map` has the inputs of that sample. False where it cannot be evaluated.
[[nodiscard]] bool smooth_outputs(MeasurementModel& map, const Gaussian& filtered, const Adjoint& adjoint,
                                  ArgumentMoments& moments, Eigen::VectorXd& mean, Eigen::VectorXd* deviation);

}  // namespace kalfem
