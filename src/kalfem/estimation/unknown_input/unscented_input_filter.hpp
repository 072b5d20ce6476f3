// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/estimation/smoother/argument_moments.hpp"
#include "kalfem/estimation/unknown_input/input_estimate.hpp"

namespace kalfem {

/// x_(k+1) = f(x_k) + G d_k + w_k,   y_k = h(x_k) + D d_k + v_k,   w ~ N(0, Q), v ~ N(0, R), nothing known of d. f and
/// h are partially linear maps; x may hold unknown parameters. The maps outlive the filter.
struct UnknownInputMaps {
  PartiallyLinearMap& process;
  PartiallyLinearMap& measurement;
  Eigen::MatrixXd G;  ///< n x p
  Eigen::MatrixXd D;  ///< l x p; zero: y_k shows d_(k-1) through the state
  Eigen::MatrixXd Q, R;

  [[nodiscard]] bool has_feedthrough() const { return !D.isZero(0.0); }
};

/// The filter of Gillijns and De Moor with moments from sigma points of the maps' arguments: joint estimation of input,
/// state and parameters. Without feed-through the input reaches y through h, which is linearised statistically about
/// the state predicted for d = 0: F = H G. Of a linear model the estimates are those of UnknownInputFilter.
///
/// Nothing is returned where a map cannot be evaluated or the measurement does not determine the input. One thread.
class UnscentedInputFilter {
public:
  /// Throws InvalidInput where sizes do not fit.
  UnscentedInputFilter(UnknownInputMaps maps, const UnscentedOptions& options = {});

  /// Predicted density of x_k -> estimate by y_k. The input of the estimate is d_k with feed-through, d_(k-1) without.
  [[nodiscard]] std::optional<InputEstimate> update(const Gaussian& predicted, const Eigen::VectorXd& y);
  /// The first sample without feed-through: nothing acted before it.
  [[nodiscard]] std::optional<InputEstimate> first_update(const Gaussian& prior, const Eigen::VectorXd& y);
  /// Estimate of x_k -> predicted density of x_(k+1); without feed-through as if d_k were 0, which the update mends.
  [[nodiscard]] std::optional<Gaussian> predict(const InputEstimate& estimate);

private:
  /// Mean and covariance of a map's image and H = cross^T P^-1, n_y x n.
  struct Image {
    Gaussian y;
    Eigen::MatrixXd linearised;
  };
  [[nodiscard]] std::optional<Image> image(PartiallyLinearMap& map, const Gaussian& x);
  [[nodiscard]] std::optional<InputMoments> moments(const Gaussian& predicted, const Eigen::VectorXd& y);

  UnknownInputMaps maps_;
  ArgumentMoments arguments_;
};

}  // namespace kalfem
