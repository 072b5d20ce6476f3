#include "kalfem/estimation/unscented_transform.hpp"

#include <cmath>

#include "kalfem/estimation/channel_factor.hpp"
#include "kalfem/estimation/small_kernels.hpp"

namespace kalfem {

using Eigen::ArrayXXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double linearisation_spread = 1e-4;  ///< in standard deviations: difference and rounding error balance

void multiply_factor(const MatrixXd& a, const MatrixXd& factor, FactorShape shape, MatrixXd& out) {
  if (shape == FactorShape::lower_triangular)
    multiply_lower(a, factor, out);
  else
    multiply(a, factor, out);
}

}  // namespace

UnscentedWeights::UnscentedWeights(const UnscentedOptions& options, Index dimension) {
  const auto n = static_cast<double>(dimension);
  const double c = options.alpha * options.alpha * (n + options.kappa);
  spread = std::sqrt(c);
  mean_centre = (c - n) / c;
  covariance_centre = mean_centre + 1.0 - options.alpha * options.alpha + options.beta;
  other = 0.5 / c;
}

UnscentedTransform UnscentedTransform::linearised() {
  UnscentedTransform transform;
  transform.linearised_ = true;
  return transform;
}

bool UnscentedTransform::apply(PartiallyLinearMap& map, const VectorXd& mean, const MatrixXd& factor,
                               FactorShape shape) {
  const bool of_channels = options_.points == SigmaPoints::of_channels && !linearised_;
  multiply_factor(map.selection, factor, shape, selected_);
  if (of_channels) {
    multiply_transposed(selected_, selected_, channel_covariance_);
    if (!channel_factor(channel_covariance_, channel_factor_)) return false;
  }
  const MatrixXd& directions = of_channels ? channel_factor_ : selected_;
  UnscentedWeights weights(options_, directions.cols());
  if (linearised_) weights.spread = linearisation_spread, weights.mean_centre = 1.0, weights.other = 0.0;
  place_points(map, mean, directions, weights.spread);
  out_.resize(in_.rows(), map.gain.cols());
  if (!map.evaluate(in_, out_)) return false;
  gather_channels(weights);

  mean_ = map.offset;
  mean_.noalias() += map.linear * mean;
  mean_.noalias() += map.gain.lazyProduct(channel_mean_);
  multiply_factor(map.linear, factor, shape, deviations_);
  if (of_channels) {
    solve_channels(channel_factor_, selected_);
    channel_delta_.noalias() = selected_.transpose() * delta_;
    add_product_transposed(map.gain, channel_delta_, deviations_);
  } else {
    add_product_transposed(map.gain, delta_, deviations_);
  }
  return true;
}

/// w at the centre and on both sides of it along each direction, one point a row.
void UnscentedTransform::place_points(const PartiallyLinearMap& map, const VectorXd& mean, const MatrixXd& directions,
                                      double spread) {
  const Index n = directions.cols(), q = directions.rows();
  in_.resize(2 * n + 1, q);
  centre_ = map.input_offset;
  centre_.noalias() += map.selection * mean;
  for (Index j = 0; j < q; ++j) {
    const double centre = in_(0, j) = centre_[j];
    const double* deviation = &directions(j, 0);
    double *plus = &in_(1, j), *minus = plus + n;
#pragma GCC ivdep
    for (Index i = 0; i < n; ++i) {
      plus[i] = centre + spread * deviation[i * q];
      minus[i] = centre - spread * deviation[i * q];
    }
  }
}

/// mean(phi), delta and Sigma from phi at all points.
void UnscentedTransform::gather_channels(const UnscentedWeights& weights) {
  const Index p = out_.cols(), n = (out_.rows() - 1) / 2;
  channel_mean_.resize(p);
  delta_.resize(n, p);
  sigma_.resize(n + 1, p);
  for (Index j = 0; j < p; ++j) {
    const auto plus = out_.col(j).segment(1, n), minus = out_.col(j).tail(n);
    channel_mean_[j] = weights.mean_centre * out_(0, j) + weights.other * (plus.sum() + minus.sum());
    const double difference = 0.5 / weights.spread, root = std::sqrt(2.0 * weights.other), centre = channel_mean_[j];
    const double *up = &out_(1, j), *down = up + n;
    double *delta = &delta_(0, j), *sigma = &sigma_(0, j);
#pragma GCC ivdep
    for (Index i = 0; i < n; ++i) {
      delta[i] = (up[i] - down[i]) * difference;
      sigma[i] = (0.5 * (up[i] + down[i]) - centre) * root;
    }
    sigma_(n, j) = out_(0, j) - channel_mean_[j];
  }
  scatter_.resize(p, p);
  const double centre_weight = linearised_ ? 0.0 : weights.covariance_centre;
  for (Index j = 0; j < p; ++j)
    for (Index i = j; i < p; ++i)
      scatter_(i, j) = scatter_(j, i) =
          (sigma_.col(i).head(n) * sigma_.col(j).head(n)).sum() + centre_weight * sigma_(n, i) * sigma_(n, j);
}

void UnscentedTransform::add_covariance(const PartiallyLinearMap& map, MatrixXd& covariance) {
  gain_scatter_.noalias() = map.gain.lazyProduct(scatter_);
  add_symmetric_product(deviations_, deviations_, covariance);
  add_symmetric_product(gain_scatter_, map.gain, covariance);
}

}  // namespace kalfem
