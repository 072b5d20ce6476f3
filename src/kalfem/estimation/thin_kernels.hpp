#pragma once

#include <Eigen/Dense>

namespace kalfem {

// Products of thin matrices, whose number of rows is a multiple of eight and whose columns are few. No allocation once
// the results have their size.

/// Y = X M, rows x columns of M.
void thin_product(const Eigen::MatrixXd& x, const Eigen::MatrixXd& m, Eigen::MatrixXd& y);
/// Y += X M.
void add_thin_product(const Eigen::MatrixXd& x, const Eigen::MatrixXd& m, Eigen::MatrixXd& y);
/// Y += X M^T.
void add_thin_product_transposed(const Eigen::MatrixXd& x, const Eigen::MatrixXd& m, Eigen::MatrixXd& y);
/// Y -= X M^T.
void subtract_thin_product_transposed(const Eigen::MatrixXd& x, const Eigen::MatrixXd& m, Eigen::MatrixXd& y);
/// M = X^T Y.
void thin_inner(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y, Eigen::MatrixXd& m);

}  // namespace kalfem
