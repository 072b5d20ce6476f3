// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// Covariance of the mean of successive blocks.
struct BlockCovariance {
  Eigen::MatrixXd of_mean;          ///< p x p
  double degrees_of_freedom = 0.0;  ///< of its variances
};

/// Of p quantities, `deviations` p x blocks about their mean, that are correlated over about `memory` blocks (1 or
/// more):
///     Cov = 1/n sum_h w_h Gamma_h,   Gamma_h = 1/n sum_k d_k d_{k+h}^T,
/// with the trapezoidal window w = 1 up to |h| = memory, and from there falling to 0 at 2 memory. A flat top leaves no
/// bias of the first order in memory / n, which would make deviations of lightly damped modes some per cent too small
/// [PR95]. The loss by the mean that was taken off is made up for by 1 - sum w_h / n. A flat-topped window may give a
/// variance that is not positive: none is smaller than half of that of Bartlett's window of the same width, and
/// the correlations are those of Bartlett's. Degrees of freedom: n / sum w_h^2.
BlockCovariance block_covariance(const Eigen::MatrixXd& deviations, Eigen::Index memory);

}  // namespace kalfem
