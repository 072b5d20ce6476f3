// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/partially_linear/argument_transform.hpp"

#include <cmath>

#include "kalfem/base/vector_loops.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double linearisation_spread = 1e-4;  ///< in standard deviations: difference and rounding error balance

}  // namespace

// Points stand in pairs about the centre, one direction a pair. Sums and differences of each pair's values are formed
// once: differences give the slopes delta, sums the mean and the scatter Sigma, in which only curvature is left. The
// linearised transform uses the same code with a small spread and no scatter.
UnscentedWeights::UnscentedWeights(const UnscentedOptions& options, Index dimension, Index directions) {
  const auto n = static_cast<double>(dimension);
  const double kappa = options.kappa.value_or(options.points == SigmaPoints::of_arguments ? 3.0 - n : 0.0);
  const double c = options.alpha * options.alpha * (n + kappa);
  spread = std::sqrt(c);
  mean_centre = (c - static_cast<double>(directions)) / c;
  covariance_centre = mean_centre + 1.0 - options.alpha * options.alpha + options.beta;
  other = 0.5 / c;
}

ArgumentTransform ArgumentTransform::linearised() {
  ArgumentTransform transform;
  transform.linearised_ = true;
  return transform;
}

bool ArgumentTransform::apply(PartiallyLinearMap& map, const VectorXd& centre,
                              const Eigen::Ref<const MatrixXd>& directions, Index dimension) {
  UnscentedWeights weights(options_, dimension, directions.cols());
  if (linearised_) weights.spread = linearisation_spread, weights.mean_centre = 1.0, weights.other = 0.0;
  place_points(centre, directions, weights.spread);
  out_.resize(in_.rows(), map.gain().cols());
  if (!map.evaluate(in_, out_)) return false;
  gather(weights);
  return true;
}

/// w at the centre and on both sides of it along each direction, one point a row.
void ArgumentTransform::place_points(const VectorXd& centre, const Eigen::Ref<const MatrixXd>& directions,
                                     double spread) {
  const Index k = directions.cols(), q = directions.rows(), stride = directions.outerStride();
  in_.resize(2 * k + 1, q);
  for (Index j = 0; j < q; ++j) {
    const double middle = in_(0, j) = centre[j];
    const double* deviation = directions.data() + j;
    double *plus = &in_(0, j) + 1, *minus = plus + k;
    KALFEM_INDEPENDENT
    for (Index i = 0; i < k; ++i) {
      plus[i] = middle + spread * deviation[i * stride];
      minus[i] = middle - spread * deviation[i * stride];
    }
  }
}

void ArgumentTransform::gather(const UnscentedWeights& weights) {
  const Index p = out_.cols(), k = (out_.rows() - 1) / 2;
  mean_.resize(p);
  delta_.resize(k, p);
  sigma_.resize(k + 1, p);
  const double difference = 0.5 / weights.spread, root = std::sqrt(2.0 * weights.other);
  for (Index j = 0; j < p; ++j) {
    const double *up = &out_(0, j) + 1, *down = up + k;
    double sum = 0.0;
    for (Index i = 0; i < 2 * k; ++i) sum += up[i];
    const double centre = mean_[j] = weights.mean_centre * out_(0, j) + weights.other * sum;
    double *delta = delta_.data() + j * k, *sigma = &sigma_(0, j);
    KALFEM_INDEPENDENT
    for (Index i = 0; i < k; ++i) {
      delta[i] = (up[i] - down[i]) * difference;
      sigma[i] = (0.5 * (up[i] + down[i]) - centre) * root;
    }
    sigma[k] = out_(0, j) - centre;
  }
  scatter_.resize(p, p);
  const double centre_weight = linearised_ ? 0.0 : weights.covariance_centre;
  for (Index j = 0; j < p; ++j)
    for (Index i = j; i < p; ++i) {
      const double *a = &sigma_(0, i), *b = &sigma_(0, j);
      double sum = 0.0;
      for (Index r = 0; r < k; ++r) sum += a[r] * b[r];
      scatter_(i, j) = scatter_(j, i) = sum + centre_weight * a[k] * b[k];
    }
}

}  // namespace kalfem
