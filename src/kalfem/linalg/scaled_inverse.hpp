// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// Inverses of covariances, n x n, by way of their correlations: the units of their variables may differ by many
/// orders. Many covariances of one size in turn allocate for the first one only.
class ScaledInverse {
public:
  /// Stays until the next call.
  const Eigen::MatrixXd& operator()(const Eigen::Ref<const Eigen::MatrixXd>& covariance) {
    scale_ = covariance.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    correlation_ = scale_.asDiagonal() * covariance * scale_.asDiagonal();
    inverse_ = factor_.compute(correlation_).solve(Eigen::MatrixXd::Identity(covariance.rows(), covariance.cols()));
    result_ = scale_.asDiagonal() * (0.5 * (inverse_ + inverse_.transpose())) * scale_.asDiagonal();
    return result_;
  }

private:
  Eigen::VectorXd scale_;
  Eigen::MatrixXd correlation_, inverse_, result_;
  Eigen::LDLT<Eigen::MatrixXd> factor_;
};

/// Of one covariance.
inline Eigen::MatrixXd scaled_inverse(const Eigen::Ref<const Eigen::MatrixXd>& covariance) {
  return ScaledInverse()(covariance);
}

}  // namespace kalfem
