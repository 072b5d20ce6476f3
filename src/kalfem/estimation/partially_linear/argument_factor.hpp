#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// Lower triangular L with L L^T = P_ww + E of the covariance of a few nonlinear arguments (lower triangle read). They
/// may depend on each other, as the motion at the ends of a short interval does: a pivot smaller than 1e-12 of its
/// argument's variance is raised to that, so that points still spread along every argument that varies at all. E is
/// below 1e-12 of the variances. An argument without variance has a zero column. A variance that is too small for its
/// covariances is what rounding left of a zero: the argument then spreads alone. False where a variance is negative or
/// not finite.
bool argument_factor(const Eigen::MatrixXd& covariance, Eigen::MatrixXd& factor);

/// B <- L^-1 B, with rows of zeros for arguments without variance. B: q x any.
void solve_arguments(const Eigen::MatrixXd& factor, Eigen::MatrixXd& b);

/// B <- L^-T B, with rows of zeros for arguments without variance. B: q x any.
void solve_arguments_transposed(const Eigen::MatrixXd& factor, Eigen::MatrixXd& b);

}  // namespace kalfem
