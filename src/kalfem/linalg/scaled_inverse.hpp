#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// Inverse of a covariance, n x n, by way of its correlation: the units of its variables may differ by many orders.
inline Eigen::MatrixXd scaled_inverse(const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd scale = covariance.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd correlation = scale.asDiagonal() * covariance * scale.asDiagonal();
  const Eigen::MatrixXd inverse =
      correlation.ldlt().solve(Eigen::MatrixXd::Identity(covariance.rows(), covariance.cols()));
  return scale.asDiagonal() * (0.5 * (inverse + inverse.transpose())) * scale.asDiagonal();
}

}  // namespace kalfem
