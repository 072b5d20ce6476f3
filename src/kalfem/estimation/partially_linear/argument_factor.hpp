#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// Lower triangular L with L L^T = P_ww + E of the covariance of a few channels (lower triangle read). Channels may
/// depend on each other, as the motion at the ends of a short interval does: a pivot smaller than 1e-12 of its
/// channel's variance is raised to that, so that points still spread along every channel that varies at all. E is below
/// 1e-12 of the variances. A channel without variance has a zero column. False where a variance is negative or not
/// finite.
bool argument_factor(const Eigen::MatrixXd& covariance, Eigen::MatrixXd& factor);

/// B <- L^-1 B, with rows of zeros for channels without variance. B: q x any.
void solve_channels(const Eigen::MatrixXd& factor, Eigen::MatrixXd& b);

/// B <- L^-T B, with rows of zeros for channels without variance. B: q x any.
void solve_channels_transposed(const Eigen::MatrixXd& factor, Eigen::MatrixXd& b);

}  // namespace kalfem
