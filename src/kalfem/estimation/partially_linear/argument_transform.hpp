// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>

#include "kalfem/estimation/partially_linear/partially_linear_map.hpp"

namespace kalfem {

/// Which random vector the sigma points stand for: the whole state, or the few nonlinear arguments w = N x + e through
/// which alone the map is not linear.
enum class SigmaPoints { of_state, of_arguments };

/// Spread and weights of the sigma points X = [m, m + sqrt(c) S, m - sqrt(c) S], S S^T = P, of n variables:
///     c = alpha^2 (n + kappa),  lambda = c - n,  W_m0 = lambda / c,  W_c0 = W_m0 + 1 - alpha^2 + beta,
///     W_i = 1 / (2 c).
/// Wan and van der Merwe (2000); Table 1 of Tsotalou et al. (2017) with its W_i corrected.
struct UnscentedOptions {
  double alpha = 1.0;
  double beta = 2.0;
  /// None: 0 for points of the state, as in the paper, and 3 - n for points of the arguments. These then stand sqrt(3)
  /// deviations out whatever their number, where the fourth moment is that of a normal distribution (Julier and
  /// Uhlmann, 2004); measured to be the best spread, docs/theory/partially-linear-ukf.md.
  std::optional<double> kappa = {};
  SigmaPoints points = SigmaPoints::of_state;
  /// Most passes of a measurement update. From the second on the measurement is linearised over sigma points of the
  /// posterior that the pass before gave (iterated_update.hpp); the prior is conditioned once, with the last one.
  int update_iterations = 1;
};

struct UnscentedWeights {
  /// For `dimension` variables that points spread in so many `directions` only, others having no variance: the pairs
  /// that would stand at the centre are counted with it.
  UnscentedWeights(const UnscentedOptions& options, Eigen::Index dimension, Eigen::Index directions);
  UnscentedWeights(const UnscentedOptions& options, Eigen::Index dimension)
      : UnscentedWeights(options, dimension, dimension) {}
  double spread;             ///< sqrt(c)
  double mean_centre;        ///< W_m0
  double covariance_centre;  ///< W_c0
  double other;              ///< W_i
};

/// The nonlinear outputs phi(w) of a map at pairs of points about a centre. For the pair along the direction s_i let
/// phi+ and phi- be phi at centre +- sqrt(c) s_i; then
///     mean(phi) = W_m0 phi_0 + W_i sum_i (phi+ + phi-),
///     delta_i   = (phi+ - phi-) / (2 sqrt(c)),
///     Sigma     = sum_i sigma_i sigma_i^T / c + W_c0 sigma_0 sigma_0^T,  sigma_i = (phi+ + phi-) / 2 - mean(phi),
/// so that the covariance of phi is sum_i delta_i delta_i^T + Sigma.
/// Arrays are kept between calls: one thread, no allocation after the first.
class ArgumentTransform {
public:
  explicit ArgumentTransform(const UnscentedOptions& options = {}) : options_(options) {}
  /// The first-order transform: the spread goes to zero, delta is phi' s_i and Sigma = 0.
  static ArgumentTransform linearised();

  /// `centre` is the mean of w, q; `directions` has the s_i as its columns, q x k. `dimension`: variables that the
  /// points stand for, of which only k have variance. False where the map could not be evaluated at some point.
  [[nodiscard]] bool apply(PartiallyLinearMap& map, const Eigen::VectorXd& centre,
                           const Eigen::Ref<const Eigen::MatrixXd>& directions, Eigen::Index dimension);
  [[nodiscard]] bool apply(PartiallyLinearMap& map, const Eigen::VectorXd& centre,
                           const Eigen::Ref<const Eigen::MatrixXd>& directions) {
    return apply(map, centre, directions, directions.cols());
  }

  [[nodiscard]] const Eigen::VectorXd& mean() const { return mean_; }        ///< mean(phi), p
  [[nodiscard]] const Eigen::MatrixXd& delta() const { return delta_; }      ///< delta_i as rows, k x p
  [[nodiscard]] const Eigen::MatrixXd& scatter() const { return scatter_; }  ///< Sigma, p x p

  [[nodiscard]] const UnscentedOptions& options() const { return options_; }

private:
  void place_points(const Eigen::VectorXd& centre, const Eigen::Ref<const Eigen::MatrixXd>& directions, double spread);
  void gather(const UnscentedWeights& weights);

  UnscentedOptions options_;
  bool linearised_ = false;
  Eigen::VectorXd mean_;
  Eigen::MatrixXd delta_, scatter_;
  Eigen::ArrayXXd in_, out_, sigma_;
};

}  // namespace kalfem
