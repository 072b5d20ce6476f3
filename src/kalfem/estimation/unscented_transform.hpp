// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/estimation/partially_linear/argument_transform.hpp"

namespace kalfem {

/// What is known of the zeros of a square root.
enum class FactorShape { general, lower_triangular };

/// The unscented transform of a partially linear map. With points of the state it equals that over the full set of
/// 2 n + 1 points, without forming the images of the linear part. With delta_i and Sigma of the ArgumentTransform along
/// the columns of N S and
///     D = A S + G [delta_1 ... delta_n]
/// the images of the pair i lie at mean(y) +- sqrt(c) D_i + G sigma_i, so that
///     mean(y) = A m + G mean(phi) + b,
///     P_yy    = D D^T + G Sigma G^T,
///     P_xy    = S D^T.
/// n columns are moved instead of 2 n + 1, and D is the statistically linearised map in square-root form.
///
/// With points of the arguments, 2 q + 1 of them, the directions are L, L L^T = P_ww = N P N^T, and since the mean of a
/// normal x is linear in w, E[x | w] = m + P_xw P_ww^-1 (w - mean(w)), the same formulas hold with
///     D = A S + G [delta_1 ... delta_q] L^-1 N S.
/// They agree where phi is linear; elsewhere the points stand sqrt(q) deviations apart instead of sqrt(n).
/// Morelande and Moran (2007); docs/theory/partially-linear-ukf.md.
/// Arrays are kept between calls: one thread, no allocation after the first.
class UnscentedTransform {
public:
  explicit UnscentedTransform(const UnscentedOptions& options = {}) : arguments_(options) {}
  /// The first-order transform: the spread goes to zero, D = (A + G phi'(w) N) S and Sigma = 0.
  static UnscentedTransform linearised();

  /// False where the map could not be evaluated at some point. `factor` is S with S S^T = P, n_x x n_x.
  [[nodiscard]] bool apply(PartiallyLinearMap& map, const Eigen::VectorXd& mean, const Eigen::MatrixXd& factor,
                           FactorShape shape = FactorShape::general);

  /// The affine model y = A_i x + b_i + e, e ~ N(0, G Sigma G^T), of the map, regressed over sigma points of another
  /// estimate m + S u, (S T)(S T)^T, and seen from m, S: mean() is then A_i m + b_i and deviations() is A_i S. S and T
  /// are lower triangular, T regular.
  [[nodiscard]] bool apply_about(PartiallyLinearMap& map, const Eigen::VectorXd& mean, const Eigen::MatrixXd& factor,
                                 const Eigen::VectorXd& u, const Eigen::MatrixXd& T);

  [[nodiscard]] const Eigen::VectorXd& mean() const { return mean_; }                    ///< mean(y)
  [[nodiscard]] const Eigen::MatrixXd& deviations() const { return deviations_; }        ///< D, n_y x n_x
  [[nodiscard]] const Eigen::MatrixXd& scatter() const { return arguments_.scatter(); }  ///< Sigma, p x p

  /// Adds P_yy to the lower triangle of `covariance`, n_y x n_y.
  void add_covariance(const PartiallyLinearMap& map, Eigen::MatrixXd& covariance);

private:
  ArgumentTransform arguments_;
  Eigen::VectorXd mean_, centre_, there_;
  Eigen::MatrixXd factor_there_;
  Eigen::MatrixXd deviations_, gain_scatter_, selected_;
  Eigen::MatrixXd argument_covariance_, argument_factor_, argument_delta_;
};

}  // namespace kalfem
