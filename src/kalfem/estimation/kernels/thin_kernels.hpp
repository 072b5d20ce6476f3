// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace kalfem {

// Products of thin matrices, whose number of rows is a multiple of eight and whose columns are few. No allocation once
// the results have their size.

/// Y = X M with the first columns of X.
void thin_product(const Eigen::MatrixXd& x, const Eigen::MatrixXd& m, Eigen::MatrixXd& y);
/// Y += X M with the first columns of X.
void add_thin_product(const Eigen::MatrixXd& x, const Eigen::MatrixXd& m, Eigen::MatrixXd& y);
/// Y -= X M^T.
void subtract_thin_product_transposed(const Eigen::MatrixXd& x, const Eigen::MatrixXd& m, Eigen::MatrixXd& y);
/// First rows of M = X^T Y, as many as X^T has. X^T is given as it stands: with as many columns as Y has rows, and its
/// rows filled up by zeros to a multiple of eight, as those of M are.
void thin_inner(const Eigen::MatrixXd& x_transposed, const Eigen::MatrixXd& y, Eigen::MatrixXd& m);

}  // namespace kalfem
