// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// Diagonal scaling d, powers of two, that brings the norms of row i and column i of diag(d)^-1 A diag(d) together.
///
/// In the coordinates z = diag(d)^-1 x a matrix such as [0 1; -w^2 0] has the norm w instead of w^2, so the matrix
/// exponential needs half as many squarings and keeps the digits that they would cost. Powers of two: no rounding.
/// A: n x n, finite. Source: Parlett and Reinsch, Numer. Math. 13 (1969) 293-304.
Eigen::VectorXd balancing_scale(Eigen::MatrixXd A);

/// The columns divided by their lengths; one without a length becomes 0. The work is linear in the number of rows.
Eigen::MatrixXd unit_columns(const Eigen::MatrixXd& columns);

}  // namespace kalfem
