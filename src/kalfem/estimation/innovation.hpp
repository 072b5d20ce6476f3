#pragma once

#include <Eigen/Dense>
#include <vector>

namespace kalfem {

/// The innovation of one measurement.
struct Innovation {
  std::vector<Eigen::Index> channels;  ///< the l channels that were measured, among all
  Eigen::VectorXd value;               ///< y - predicted y, l
  Eigen::MatrixXd covariance;          ///< P_yy + R, l x l, lower triangle
  double nis = 0.0;                    ///< normalised innovation squared, value^T covariance^-1 value
  double log_likelihood = 0.0;         ///< of this measurement given those before
};

/// v <- L^-1 v for a few values, L lower triangular.
void whiten(const Eigen::MatrixXd& lower, Eigen::VectorXd& vector);

/// K = J L^-1 from J = P_xy L^-T, P_yy + R = L L^T.
Eigen::MatrixXd gain_of(const Eigen::MatrixXd& whitened_cross, const Eigen::MatrixXd& lower);

/// NIS and log-likelihood from the Cholesky factor L of the innovation's covariance and `whitened` = L^-1 value.
void score(Innovation& innovation, const Eigen::MatrixXd& factor, const Eigen::VectorXd& whitened);

}  // namespace kalfem
