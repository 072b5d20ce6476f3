// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/adaptive_noise.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double stated_share = 1.0 / 40.0;  ///< of the memory that the stated noise of a sensor counts for
constexpr double fewest_stated = 2.0;        ///< samples that it counts for
constexpr double least_noise = 1e-6;         ///< of the stated variance: a channel that rests must not become exact
constexpr double many = 0.25;                ///< share of samples set aside that is no longer a matter of single ones
constexpr double largest_rate = 20.0;        ///< of ln(factor of the process noise), per memory
constexpr double smallest_scale = 0.5, largest_scale = 20.0;  ///< of a sensor's variance, per sample

/// S as the filter expects it of sensors whose noise is R, without what a robust update adds.
MatrixXd expected_covariance(const Innovation& innovation) {
  MatrixXd covariance = innovation.covariance.selfadjointView<Eigen::Lower>();
  if (innovation.added_variance.size() > 0) covariance.diagonal() -= innovation.added_variance;
  return covariance;
}

/// The slope g of the log-likelihood along some parameters, and its information.
struct Slope {
  VectorXd value;
  MatrixXd information;
};

/// `relative`: S^-1 S_i; `moved`: v_i, of which empty ones are zero.
Slope slope_of(const Eigen::LLT<MatrixXd>& S, const VectorXd& v, const std::vector<MatrixXd>& derivative,
               const std::vector<VectorXd>& moved) {
  const auto count = static_cast<Index>(derivative.size());
  Slope slope{VectorXd(count), MatrixXd(count, count)};
  const VectorXd u = S.solve(v);
  const double excess = std::max(1.0, u.dot(v) / static_cast<double>(v.size()));
  std::vector<MatrixXd> relative;
  for (const auto& each : derivative) relative.push_back(S.solve(each));
  for (std::size_t i = 0; i < derivative.size(); ++i) {
    const auto row = static_cast<Index>(i);
    slope.value[row] = 0.5 * (u.dot(derivative[i] * u) - relative[i].trace());
    if (moved[i].size() > 0) slope.value[row] -= u.dot(moved[i]);
    for (std::size_t j = 0; j < derivative.size(); ++j) {
      double& entry = slope.information(row, static_cast<Index>(j));
      entry = 0.5 * relative[i].cwiseProduct(relative[j].transpose()).sum();
      if (moved[i].size() > 0 && moved[j].size() > 0) entry += moved[i].dot(S.solve(moved[j])) / excess;
    }
  }
  return slope;
}

}  // namespace

NoiseRecursion::NoiseRecursion(const AdaptiveNoiseOptions& options, MatrixXd noise, double step, double least_factor)
    : options_(options),
      forgetting_(-std::expm1(-step / options.memory)),
      begin_(0.5 * std::max(fewest_stated, stated_share / forgetting_)),
      largest_move_(largest_rate * forgetting_),
      noise_(std::move(noise)),
      least_noise_(least_noise * noise_.diagonal()),
      share_(VectorXd::Zero(noise_.rows())),
      set_aside_(static_cast<std::size_t>(noise_.rows())),
      information_(MatrixXd::Zero(noise_.rows() + 1, noise_.rows() + 1)),
      least_log_factor_(std::log(least_factor)) {}

bool NoiseRecursion::counts(Index channel) const {
  return !set_aside_[static_cast<std::size_t>(channel)] || share_[channel] > many;
}

void NoiseRecursion::note_set_aside(const Innovation& innovation) {
  set_aside_.assign(set_aside_.size(), false);
  for (const auto& each : innovation.set_aside)
    if (each.outlier) set_aside_[static_cast<std::size_t>(each.channel)] = true;
  const double least = forgetting_;
  const auto note = [&](Index channel) {
    const double flagged = set_aside_[static_cast<std::size_t>(channel)] ? 1.0 : 0.0;
    const double weight = std::max(least, 1.0 / (2.0 * begin_ + 2.0 * information_(channel, channel)));
    share_[channel] += weight * (flagged - share_[channel]);
  };
  for (const Index channel : innovation.channels) note(channel);
  for (const auto& each : innovation.set_aside)
    if (each.outlier && std::ranges::find(innovation.channels, each.channel) == innovation.channels.end())
      note(each.channel);
}

/// Correlations of R stay.
void NoiseRecursion::scale(Index channel, double factor) {
  const double before = noise_(channel, channel);
  const double now = std::max(least_noise_[channel], before * std::clamp(factor, smallest_scale, largest_scale));
  const double ratio = std::sqrt(now / before);
  noise_.row(channel) *= ratio;
  noise_.col(channel) *= ratio;
}

/// Channels that the gate left out, each by itself.
void NoiseRecursion::learn_gated(const Innovation& innovation) {
  for (const auto& each : innovation.set_aside) {
    const Index j = each.channel;
    const bool left_out = std::ranges::find(innovation.channels, j) == innovation.channels.end();
    if (!each.outlier || !left_out || !counts(j)) continue;
    const double variance = each.deviation * each.deviation, share = noise_(j, j) / variance;
    const double slope = 0.5 * share * (each.innovation * each.innovation / variance - 1.0);
    information_(j, j) += 0.5 * share * share - forgetting_ * information_(j, j);
    scale(j, 1.0 + slope / (information_(j, j) + begin_));
  }
}

void NoiseRecursion::learn(const Innovation& innovation, const Innovation* more, double log_ratio) {
  note_set_aside(innovation);
  if (options_.sensors) learn_gated(innovation);
  const auto& channels = innovation.channels;
  const auto l = static_cast<Index>(channels.size());
  if (l == 0) return;
  const MatrixXd S = expected_covariance(innovation);
  const Eigen::LLT<MatrixXd> factor(S);
  if (factor.info() != Eigen::Success) return;

  // The parameters that this sample tells of: their places in J, and derivatives.
  std::vector<Index> places;
  std::vector<MatrixXd> derivative;
  std::vector<VectorXd> moved;
  for (Index i = 0; options_.sensors && i < l; ++i) {
    const Index channel = channels[static_cast<std::size_t>(i)];
    if (!counts(channel)) continue;
    places.push_back(channel);
    moved.emplace_back();
    derivative.emplace_back(MatrixXd::Zero(l, l));
    for (Index k = 0; k < l; ++k) {
      const double half = 0.5 * noise_(channel, channels[static_cast<std::size_t>(k)]);
      derivative.back()(i, k) += half;
      derivative.back()(k, i) += half;
    }
  }
  const bool single_outlier = std::ranges::any_of(
      innovation.set_aside, [&](const auto& each) { return each.outlier && !counts(each.channel); });
  if (options_.process && more && !single_outlier && more->channels == channels) {
    places.push_back(noise_.rows());
    derivative.emplace_back((expected_covariance(*more) - S) / log_ratio);
    moved.emplace_back((more->value - innovation.value) / log_ratio);
  }
  const Slope slope = slope_of(factor, innovation.value, derivative, moved);
  if (places.empty() || !slope.value.allFinite() || !slope.information.allFinite()) return;

  MatrixXd J = information_(places, places) * (1.0 - forgetting_) + slope.information;
  information_(places, places) = J;
  for (Index i = 0; i < J.rows(); ++i) {
    const bool of_process = places[static_cast<std::size_t>(i)] == noise_.rows();
    J(i, i) += of_process ? std::sqrt(J(i, i)) + std::numeric_limits<double>::min() : begin_;
  }
  const VectorXd step = J.ldlt().solve(slope.value);
  if (!step.allFinite()) return;
  for (Index i = 0; i < step.size(); ++i) {
    const Index place = places[static_cast<std::size_t>(i)];
    if (place < noise_.rows())
      scale(place, 1.0 + step[i]);
    else
      log_factor_ = std::max(least_log_factor_, log_factor_ + std::clamp(step[i], -largest_move_, largest_move_));
  }
}

double NoiseRecursion::process_factor() const { return std::exp(log_factor_); }

/// A standard deviation's logarithm is half that of its variance.
VectorXd NoiseRecursion::sensor_uncertainty() const {
  return 0.5 * (information_.diagonal().head(noise_.rows()).array() + begin_).rsqrt();
}

double NoiseRecursion::process_uncertainty() const {
  const double J = information_(noise_.rows(), noise_.rows());
  return J > 0.0 ? 1.0 / std::sqrt(J) : std::numeric_limits<double>::infinity();
}

}  // namespace kalfem
