// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace kalfem {

/// Lower triangular L with L L^T = P_ww + E of the covariance of a few nonlinear arguments (lower triangle read). They
/// may depend on each other, as the motion at the ends of a short interval does: a pivot smaller than 1e-12 of its
/// argument's variance is raised to that, so that points still spread along every argument that varies at all. E is
/// below 1e-12 of the variances. An argument without variance has a zero column. A variance that is too small for its
/// covariances is what rounding left of a zero: the argument then spreads alone. False where a variance is negative or
/// not finite.
bool argument_factor(const Eigen::MatrixXd& covariance, Eigen::MatrixXd& factor);

/// What becomes of arguments that depend on others.
enum class Dependent { raised, left_out };

/// The same without the columns that would be zero, and where dependent arguments are left out without those that would
/// be raised: the places of the others are in `independent` in rising order; the rest of the factor is zero. It has q
/// columns, and below its q rows more of zeros up to a multiple of eight.
/// Motions at the ends of many short intervals are many arguments, but together vary in no more directions than the
/// state; leaving the others out costs slopes along directions below 1e-6 of a deviation.
bool independent_argument_factor(const Eigen::MatrixXd& covariance, Dependent dependent, Eigen::MatrixXd& factor,
                                 std::vector<Eigen::Index>& independent);

/// F^T with P_ww F = L B in the columns of the arguments, L and `independent` as above: zero for arguments that depend
/// on others. B: the first of at least as many rows as are independent; F^T: columns of B, filled up by rows of zeros
/// to a multiple of eight, x q.
void solve_independent_transposed(const Eigen::MatrixXd& factor, const std::vector<Eigen::Index>& independent,
                                  const Eigen::MatrixXd& b, Eigen::MatrixXd& f_transposed);

/// B <- L^-1 B, with rows of zeros for arguments without variance. B: q x any.
void solve_arguments(const Eigen::MatrixXd& factor, Eigen::MatrixXd& b);

}  // namespace kalfem
