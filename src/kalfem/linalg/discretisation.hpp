// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// One exact step x1 = transition x0 + begin_weight u0 + end_weight u1.
struct FirstOrderHold {
  Eigen::MatrixXd transition;    ///< exp(A h), n x n
  Eigen::MatrixXd begin_weight;  ///< weight of the input at the interval's begin, n x m
  Eigen::MatrixXd end_weight;    ///< weight of the input at the interval's end, n x m
};

/// Exact discretisation of x' = A x + B u for an input that is linear in time over each interval of length h,
///     u(t) = u0 + (u1 - u0) t / h,
/// from the upper block row [exp(Ah), G, G1] of
///     exp [ A h  B h  0 ]
///         [  0    0   I ]
///         [  0    0   0 ],      x1 = exp(Ah) x0 + G u0 + G1 (u1 - u0).
/// A: n x n (singular and stiff matrices included), B: n x m, h [s] > 0. Throws InvalidInput where a value is not
/// finite or the shapes do not match. Source: Van Loan, IEEE Trans. Autom. Control 23 (1978) 395-404.
FirstOrderHold first_order_hold(const Eigen::Ref<const Eigen::MatrixXd>& A, const Eigen::Ref<const Eigen::MatrixXd>& B,
                                double h);

/// One exact step for an input that is quadratic in time, from its values at begin, middle and end.
struct QuadraticHold {
  /// x = transition x0 + begin_weight u0 + middle_weight u_m + end_weight u1 at one instant.
  struct Instant {
    Eigen::MatrixXd transition;                               ///< n x n
    Eigen::MatrixXd begin_weight, middle_weight, end_weight;  ///< n x m
  };
  Instant middle, end;
  /// Times u0 - 2 u_m + u1: x1 less what it is where u is linear over either half, n x m.
  Eigen::MatrixXd curvature_weight;
};

/// Exact discretisation of x' = A x + B u for an input that is quadratic over an interval of length h,
///     u(t) = a0 + a1 s + a2 s^2 / 2,   s = 2 t / h,
/// through u(0), u(h/2) and u(h), from
///     x(h/2) = exp(A h/2) x0 + P_1 a0 + P_2 a1 + P_3 a2,     P_j = (h/2) phi_j(A h/2) B,
/// all of one block exponential as that of first_order_hold(), and the same over the second half. Arguments and errors
/// are those of first_order_hold(). Source: Hochbruck, Ostermann, Acta Numerica 19 (2010) 209-286, section 2.
QuadraticHold quadratic_hold(const Eigen::Ref<const Eigen::MatrixXd>& A, const Eigen::Ref<const Eigen::MatrixXd>& B,
                             double h);

/// Covariance that continuous white noise of density Qc adds to the state of x' = A x + w over an interval,
///     Q(h) = int_0^h exp(A s) Qc exp(A^T s) ds.
///
/// Van Loan's block exponential gives Q over a short interval h0 = h / 2^k with |A| h0 <= 1/2, and
///     Q(2 h0) = Q(h0) + exp(A h0) Q(h0) exp(A h0)^T
/// doubles it k times; unlike the block exponential over the whole of h, which contains exp(-A h), that stays bounded
/// for stiff, damped systems. A: n x n, Qc: n x n symmetric positive semi-definite [state^2/s], h [s] > 0. The result
/// is symmetric. Throws InvalidInput where a value is not finite or the shapes do not match. Source: Van Loan, IEEE
/// Trans. Autom. Control 23 (1978) 395-404.
Eigen::MatrixXd process_noise_covariance(const Eigen::Ref<const Eigen::MatrixXd>& A,
                                         const Eigen::Ref<const Eigen::MatrixXd>& Qc, double h);

}  // namespace kalfem
