// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>

namespace kalfem {

/// A quadratic model of a cost around a point: F(d) = |A d + b|^2 / 2, A rows x p with rows >= p.
struct QuadraticModel {
  Eigen::MatrixXd matrix;  ///< A
  Eigen::VectorXd offset;  ///< b

  [[nodiscard]] Eigen::VectorXd gradient() const { return matrix.transpose() * offset; }
  /// F(0) - F(d)
  [[nodiscard]] double reduction(const Eigen::VectorXd& change) const;
};

/// Derivatives of |r|^2 / 2 at one point: J = Q R, so that R^T R = J^T J and R^T Q^T r = J^T r.
struct SecantEnd {
  Eigen::MatrixXd jacobian_factor;     ///< R, p x p
  Eigen::VectorXd projected_residual;  ///< Q^T r, p
};

/// The secant approximation S of the second-order part of the Hessian of |r|^2 / 2,
///   H = J^T J + sum_k r_k d2 r_k,
/// after a step s: the symmetric matrix with S s = z that is nearest to the one before in the sense of Davidon,
/// Fletcher and Powell, after that one was shortened where it exceeds z along s [DGW81]. From the ends of the step
/// alone
///   z = g_end - g_begin - (J_end^T J_end + J_begin^T J_begin) s / 2,   g = J^T r,
/// the trapezoidal rule, so that no Jacobian needs to be kept. `before` 0 x 0 counts as zero.
Eigen::MatrixXd updated_second_order(const Eigen::MatrixXd& before, const Eigen::VectorXd& step, const SecantEnd& begin,
                                     const SecantEnd& end);

/// The model with the same gradient and the Hessian A^T A + S; nothing where that is not positive definite.
std::optional<QuadraticModel> with_second_order(const QuadraticModel& model, const Eigen::MatrixXd& second_order);

}  // namespace kalfem
