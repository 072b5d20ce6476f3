// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/iterated_update.hpp"

#include "kalfem/estimation/filter.hpp"
#include "kalfem/estimation/kernels/small_kernels.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double tolerance = 1e-4;  ///< of a move, in posterior standard deviations

/// A map without gain is linear: each pass would be the first.
bool is_linear(const PartiallyLinearMap& map) { return map.moving_gain() == 0 && map.gain().isZero(0.0); }

}  // namespace

bool ArgumentMoves::settle(const VectorXd& mean, const VectorXd& deviation) {
  const bool rests = any_ && ((mean - mean_).array().abs() <= tolerance * deviation.array()).all() &&
                     ((deviation - deviation_).array().abs() <= tolerance * deviation.array()).all();
  any_ = true;
  mean_ = mean;
  deviation_ = deviation;
  return rests;
}

void IteratedUpdate::refine(const Measurement& measurement, int most, UnscentedTransform& transform) {
  if (is_linear(measurement.map) || !condition(measurement, transform)) return;
  moves_.restart();
  for (int pass = 1; pass < most; ++pass) {
    before_ = transform;
    const bool rests = settled(measurement);
    const bool usable =
        transform.apply_about(measurement.map, measurement.mean, measurement.factor, shift_, contraction_);
    if (!usable || !condition(measurement, transform)) {
      transform = before_;
      return;
    }
    if (rests) return;
  }
}

/// u and T of the posterior under the transform's affine model. False where a covariance is not positive definite.
bool IteratedUpdate::condition(const Measurement& measurement, UnscentedTransform& transform) {
  const auto& channels = measurement.channels;
  const Index n = measurement.mean.size(), outputs = transform.mean().size();
  all_channels_.setZero(outputs, outputs);
  transform.add_covariance(measurement.map, all_channels_);
  all_channels_.triangularView<Eigen::StrictlyUpper>() = all_channels_.transpose();
  covariance_ = measurement.noise;
  covariance_ += all_channels_(channels, channels);
  if (!cholesky(covariance_, 0.0, root_)) return false;
  value_ = measurement.y - transform.mean()(channels);
  whiten(root_, value_);
  weights_ = transform.deviations()(channels, Eigen::all).transpose();
  solve_on_the_right(root_, weights_);
  shift_.noalias() = weights_ * value_;
  left_.setIdentity(n, n);
  subtract_square(weights_, left_);
  return cholesky(left_, 0.0, contraction_) && shift_.allFinite();
}

/// Whether the arguments' posterior is that of the pass before.
bool IteratedUpdate::settled(const Measurement& measurement) {
  multiply_lower(measurement.map.selection(), measurement.factor, spread_);
  multiply_lower(spread_, contraction_, spread_there_);
  argument_mean_ = measurement.map.input_offset();
  argument_mean_.noalias() += measurement.map.selection() * measurement.mean;
  argument_mean_.noalias() += spread_ * shift_;
  return moves_.settle(argument_mean_, spread_there_.rowwise().norm());
}

}  // namespace kalfem
