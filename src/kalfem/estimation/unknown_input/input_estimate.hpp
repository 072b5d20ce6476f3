// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>

#include "kalfem/estimation/gaussian.hpp"

namespace kalfem {

/// Moments of state and measurement before an input d is known that nothing is assumed of,
///     x = x_0 + G d,     y = y_0 + F d,
/// with x_0 and y_0 as the filter predicts them for d = 0: of a linear model, or by an unscented transform.
struct InputMoments {
  Gaussian state;                         ///< of x_0
  Eigen::MatrixXd cross;                  ///< covariance of x_0 and y_0, n x l
  Eigen::VectorXd innovation;             ///< measured y - mean of y_0, l
  Eigen::MatrixXd innovation_covariance;  ///< of y_0 with the sensors' noise, l x l
  Eigen::MatrixXd state_input;            ///< G, n x p
  Eigen::MatrixXd output_input;           ///< F, l x p
};

/// State and input after a measurement, with their joint covariance.
struct InputEstimate {
  Gaussian state;
  Gaussian input;
  Eigen::MatrixXd cross;  ///< covariance of state and input, n x p
};

/// The unbiased estimate of least variance of state and input,
///     d = M e,  M = (F^T S^-1 F)^-1 F^T S^-1,     x = x_0 + K (e - F d) + G d,  K = P_xy S^-1,
/// which is the limit of the Kalman update as the variance of d goes to infinity. Gillijns and De Moor, Automatica 43
/// (2007) 111-116 (F = C G) and 934-937 (direct feed-through: F = D, G = 0). Nothing where F has not full column rank:
/// the measurement does not determine the input.
std::optional<InputEstimate> estimate_input(const InputMoments& moments);
/// The same where the input is known to be zero: the Kalman update.
InputEstimate estimate_without_input(const InputMoments& moments);

/// x_(k+1) = A x_k + G d_k + w_k,   y_k = C x_k + D d_k + v_k,   w ~ N(0, Q), v ~ N(0, R), nothing known of d.
struct UnknownInputModel {
  Eigen::MatrixXd A, G, C, D, Q, R;

  [[nodiscard]] Eigen::Index states() const { return A.rows(); }
  /// Whether D is not zero, so that y_k shows d_k; otherwise y_k shows d_(k-1).
  [[nodiscard]] bool has_feedthrough() const { return !D.isZero(0.0); }
};

/// What instantaneous estimation of state and input needs. Maes, Lourens, Van Nimmen, Reynders, De Roeck and Lombaert,
/// Mechanical Systems and Signal Processing 52-53 (2015) 378-404.
struct Invertibility {
  bool instantaneous = false;  ///< D, or without feed-through C G, has full column rank
  /// [A - I, G; C, D] has full column rank. Otherwise a constant input leaves no trace, as with accelerations only: the
  /// estimates drift.
  bool sees_constants = false;
  /// No finite transmission zero lies on or outside the unit circle: errors of the estimates die out. For as many
  /// sensors as inputs only; with more there are none in general, and this is true.
  bool stable = false;
};
Invertibility invertibility_of(const UnknownInputModel& model);

/// The filter of Gillijns and De Moor as two functions of densities.
class UnknownInputFilter {
public:
  /// Throws InvalidInput where sizes do not fit.
  explicit UnknownInputFilter(UnknownInputModel model);

  /// Predicted density of x_k -> estimate by y_k. The input of the estimate is d_k with feed-through, d_(k-1) without.
  [[nodiscard]] std::optional<InputEstimate> update(const Gaussian& predicted, const Eigen::VectorXd& y) const;
  /// The first sample without feed-through: nothing acted before it.
  [[nodiscard]] InputEstimate first_update(const Gaussian& prior, const Eigen::VectorXd& y) const;
  /// Estimate of x_k -> predicted density of x_(k+1); without feed-through as if d_k were 0, which the update mends.
  [[nodiscard]] Gaussian predict(const InputEstimate& estimate) const;

private:
  [[nodiscard]] InputMoments moments(const Gaussian& predicted, const Eigen::VectorXd& y) const;

  UnknownInputModel model_;
};

}  // namespace kalfem
