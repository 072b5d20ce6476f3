#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// d = argmin |A d + b|^2 with lower <= d <= upper, where A may be rank deficient: what A does not determine stays as
/// near to zero as the bounds let it. An active-set method in the manner of [SP95], for a few columns: held unknowns
/// are joined by those that a step runs into and released where the residual pulls inwards. The free ones follow from a
/// singular value decomposition with columns scaled to length one, in which singular values below `rank_tolerance`
/// times the largest count as zero. A is rows x n with rows >= n, lower <= 0 <= upper.
Eigen::VectorXd bounded_least_squares(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& offset,
                                      const Eigen::VectorXd& lower, const Eigen::VectorXd& upper,
                                      double rank_tolerance);

}  // namespace kalfem
