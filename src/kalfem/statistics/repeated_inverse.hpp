#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// scaled_inverse() of many covariances of one size, to the same bits: it allocates for the first one only.
class RepeatedInverse {
public:
  /// Stays until the next call.
  const Eigen::MatrixXd& operator()(const Eigen::MatrixXd& covariance) {
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

}  // namespace kalfem
