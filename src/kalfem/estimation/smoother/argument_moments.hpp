// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/estimation/partially_linear/argument_transform.hpp"

namespace kalfem {

/// Statistical linearisation of the nonlinear outputs of a partially linear map about w ~ N(m, P_ww),
///     phi(w) = mean(phi) + F^T (w - m) + error,     F = P_ww^-1 P_wphi,
/// from sigma points of w; the error is not correlated with w. One thread.
class ArgumentMoments {
public:
  explicit ArgumentMoments(ArgumentTransform transform) : transform_(std::move(transform)) {}

  /// False where a variance is not finite or the map cannot be evaluated. A map whose gain is zero is not evaluated.
  [[nodiscard]] bool evaluate(PartiallyLinearMap& map, const Eigen::VectorXd& centre,
                              const Eigen::MatrixXd& covariance);

  [[nodiscard]] const Eigen::VectorXd& mean() const { return mean_; }                ///< mean(phi), p
  [[nodiscard]] const Eigen::MatrixXd& slopes() const { return slopes_; }            ///< F, q x p
  [[nodiscard]] const Eigen::MatrixXd& covariance() const { return phi_variance_; }  ///< of phi, p x p

private:
  ArgumentTransform transform_;
  Eigen::VectorXd mean_;
  Eigen::MatrixXd slopes_, slopes_transposed_, phi_variance_, factor_, covariance_;
  std::vector<Eigen::Index> independent_;
};

}  // namespace kalfem
