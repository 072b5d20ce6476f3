#pragma once

#include <Eigen/Dense>

#include "kalfem/estimation/partially_linear_map.hpp"

namespace kalfem {

/// Which random vector the sigma points stand for: the whole state, or the few channels w = N x + e through which alone
/// the map is not linear.
enum class SigmaPoints { of_state, of_channels };

/// Spread and weights of the sigma points X = [m, m + sqrt(c) S, m - sqrt(c) S], S S^T = P, of n variables:
///     c = alpha^2 (n + kappa),  lambda = c - n,  W_m0 = lambda / c,  W_c0 = W_m0 + 1 - alpha^2 + beta,
///     W_i = 1 / (2 c).
/// Wan and van der Merwe (2000); Table 1 of Tsotalou et al. (2017) with its W_i corrected.
struct UnscentedOptions {
  double alpha = 1.0;
  double beta = 2.0;
  double kappa = 0.0;
  SigmaPoints points = SigmaPoints::of_state;
};

struct UnscentedWeights {
  UnscentedWeights(const UnscentedOptions& options, Eigen::Index dimension);
  double spread;             ///< sqrt(c)
  double mean_centre;        ///< W_m0
  double covariance_centre;  ///< W_c0
  double other;              ///< W_i
};

/// What is known of the zeros of a square root.
enum class FactorShape { general, lower_triangular };

/// The unscented transform of a partially linear map. With points of the state it equals that over the full set of
/// 2 n + 1 points, without forming the images of the linear part. For the pair i let phi+ and phi- be phi at m +- sqrt(c) s_i; with
///     delta_i = (phi+ - phi-) / (2 sqrt(c)),   sigma_i = (phi+ + phi-) / 2 - mean(phi),   D = A S + G [delta_1 ...
///     delta_n]
/// the images of the pair lie at mean(y) +- sqrt(c) D_i + G sigma_i, so that
///     mean(y) = A m + G mean(phi) + b,
///     P_yy    = D D^T + G Sigma G^T,      Sigma = sum_i sigma_i sigma_i^T / c + W_c0 sigma_0 sigma_0^T,
///     P_xy    = S D^T.
/// n columns are moved instead of 2 n + 1, and D is the statistically linearised map in square-root form.
///
/// With points of the channels, 2 q + 1 of them, the square root is L L^T = P_ww = N P N^T, and since the mean of a
/// normal x is linear in w, E[x | w] = m + P_xw P_ww^-1 (w - mean(w)), the same formulas hold with
///     D = A S + G [delta_1 ... delta_q] L^-1 N S.
/// They agree where phi is linear; elsewhere the points stand sqrt(q) deviations apart instead of sqrt(n), and the
/// higher moments of the directions in which the map is linear cannot disturb. Morelande and Moran (2007); Steinbring
/// and Hanebeck (2014).
/// Arrays are kept between calls: one thread, no allocation after the first.
class UnscentedTransform {
public:
  explicit UnscentedTransform(const UnscentedOptions& options = {}) : options_(options) {}
  /// The first-order transform: the spread goes to zero, D = (A + G phi'(w) N) S and Sigma = 0.
  static UnscentedTransform linearised();

  /// False where the map could not be evaluated at some point. `factor` is S with S S^T = P, n_x x n_x.
  [[nodiscard]] bool apply(PartiallyLinearMap& map, const Eigen::VectorXd& mean, const Eigen::MatrixXd& factor,
                           FactorShape shape = FactorShape::general);

  [[nodiscard]] const Eigen::VectorXd& mean() const { return mean_; }              ///< mean(y)
  [[nodiscard]] const Eigen::MatrixXd& deviations() const { return deviations_; }  ///< D, n_y x n_x
  [[nodiscard]] const Eigen::MatrixXd& scatter() const { return scatter_; }        ///< Sigma, p x p

  /// Adds P_yy to the lower triangle of `covariance`, n_y x n_y.
  void add_covariance(const PartiallyLinearMap& map, Eigen::MatrixXd& covariance);

private:
  void place_points(const PartiallyLinearMap& map, const Eigen::VectorXd& mean, const Eigen::MatrixXd& directions,
                    double spread);
  void gather_channels(const UnscentedWeights& weights);

  UnscentedOptions options_;
  bool linearised_ = false;
  Eigen::VectorXd mean_, centre_, channel_mean_;
  Eigen::MatrixXd deviations_, scatter_, gain_scatter_, selected_, delta_;
  Eigen::MatrixXd channel_covariance_, channel_factor_, channel_delta_;
  Eigen::ArrayXXd in_, out_, sigma_;
};

}  // namespace kalfem
