// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// The difference P - J J^T is wrong by rounding in proportion to P. Widening the variances by a little more than that
/// keeps it positive semi-definite where a measurement leaves almost nothing of them.
inline constexpr double rounding_allowance = 1e-13;

/// Lower triangular S with S S^T = P of a symmetric positive semi-definite matrix (lower triangle read): Cholesky, and
/// where P is singular (states known exactly) a pivoted Cholesky of its correlation matrix, which drops directions of
/// no variance. False where P has a negative variance beyond rounding (smaller than -1e-9 of the correlation matrix) or
/// a value that is not finite. `factor` then holds nothing of use.
bool covariance_factor(const Eigen::MatrixXd& covariance, Eigen::MatrixXd& factor);

/// Lower triangular L with L L^T = sum of the products of the given block of columns, [A_1 A_2 ...], by a QR
/// factorisation of the transposed array. Works in `array`, (columns) x n, which holds the transposed columns on entry.
void triangularise(Eigen::MatrixXd& array, Eigen::MatrixXd& lower);

/// L L^T - v v^T in place (hyperbolic rotations); false, with L unchanged, where the result would not be positive
/// definite. Golub and Van Loan, Matrix Computations, 4th ed., section 6.5.4.
bool downdate(Eigen::MatrixXd& lower, Eigen::VectorXd vector);

}  // namespace kalfem
