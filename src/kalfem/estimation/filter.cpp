// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/filter.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "kalfem/base/vector_loops.hpp"
#include "kalfem/estimation/covariance_filter.hpp"
#include "kalfem/estimation/partially_linear/partially_linear_filter.hpp"
#include "kalfem/estimation/square_root_filter.hpp"

namespace kalfem {

std::string to_string(FilterKind kind) {
  switch (kind) {
    case FilterKind::unscented:
      return "ukf";
    case FilterKind::unscented_square_root:
      return "ukf_square_root";
    case FilterKind::partially_linear:
      return "partially_linear_ukf";
    case FilterKind::partially_linear_square_root:
      return "partially_linear_ukf_square_root";
    case FilterKind::extended:
      return "ekf";
  }
  return {};
}

std::string to_string(FilterOutcome outcome) {
  switch (outcome) {
    case FilterOutcome::usable:
      return "usable";
    case FilterOutcome::model_not_evaluable:
      return "a connector force was not finite at a sigma point";
    case FilterOutcome::linear_part_impossible:
      return "an unknown of the linear part reached a value that is physically impossible";
    case FilterOutcome::covariance_not_positive_definite:
      return "the covariance of the state is no longer positive definite";
    case FilterOutcome::innovation_not_positive_definite:
      return "the covariance of the innovations is singular";
  }
  return {};
}

Filter::Filter(FilterModel model) : model_(std::move(model)) {
  assert(model_.process_noise.rows() == model_.process.linear().rows());
  assert(model_.measurement_noise.rows() == model_.measurement.linear().rows());
}

// Reduces the measurement to the channels with a finite value and leaves the conditioning to the filter's own form. A
// channel without a value carries no information: its row and column drop out of R, P_yy and P_xy. Single channels are
// judged by their expected innovation. Where one is to count less, its innovation is formed again with what is left of
// it: that happens at few samples, so the common way stays as short as without.
FilterOutcome Filter::update(const Eigen::VectorXd& y, Innovation& innovation,
                             const std::vector<Eigen::Index>& held_out) {
  assert(y.size() == channels());
  auto& present = innovation.channels;
  present.clear();
  innovation.set_aside.clear();
  innovation.relinearised = false;
  innovation.added_variance.resize(0);
  for (Eigen::Index channel = 0; channel < y.size(); ++channel)
    if (std::isfinite(y[channel])) present.push_back(channel);
  if (present.empty()) return FilterOutcome::usable;
  take_channels(y, present);
  if (const auto outcome = expect(values_, noise_, innovation); outcome != FilterOutcome::usable) return outcome;
  if ((outliers_.treatment == OutlierTreatment::keep && held_out.empty()) || !screen(held_out, innovation))
    return correct(noise_, innovation);
  if (present.empty()) return FilterOutcome::usable;
  take_channels(y, present);
  Eigen::MatrixXd noise = noise_;
  noise.diagonal() += added_variance_;
  innovation.added_variance = added_variance_;
  if (const auto outcome = expect(values_, noise, innovation); outcome != FilterOutcome::usable) return outcome;
  return correct(noise, innovation);
}

void Filter::set_measurement_noise(const Eigen::MatrixXd& noise) {
  model_.measurement_noise = noise;
  noise_channels_.clear();
}

/// Channels come and go in stretches, so R of the present ones is formed only where they change.
void Filter::take_channels(const Eigen::VectorXd& y, const std::vector<Eigen::Index>& channels) {
  if (channels != noise_channels_) {
    noise_channels_ = channels;
    noise_ = model_.measurement_noise(channels, channels);
  }
  values_.resize(static_cast<Eigen::Index>(channels.size()));
  for (Eigen::Index i = 0; i < values_.size(); ++i) values_[i] = y[channels[static_cast<std::size_t>(i)]];
}

/// Takes the channels out that are held out or gated, and sets the variance that the others are given in addition:
/// S_ii / w in the place of S_ii. False where every channel counts in full.
bool Filter::screen(const std::vector<Eigen::Index>& held_out, Innovation& innovation) {
  bool changed = false;
  std::vector<Eigen::Index> kept;
  added_variance_.setZero(innovation.value.size());
  for (Eigen::Index i = 0; i < innovation.value.size(); ++i) {
    const Eigen::Index channel = innovation.channels[static_cast<std::size_t>(i)];
    const double variance = innovation.covariance(i, i), deviation = std::sqrt(variance);
    const double e = innovation.value[i] / deviation;
    const bool held = std::ranges::find(held_out, channel) != held_out.end();
    const double weight = held ? 0.0 : outlier_weight(outliers_, e);
    changed = changed || weight < 1.0;
    const bool outlier = !held && outliers_.treatment != OutlierTreatment::keep && std::abs(e) > outliers_.limit;
    if (held || outlier) innovation.set_aside.push_back({channel, 0, innovation.value[i], deviation, outlier});
    if (!(weight > 0.0)) continue;
    added_variance_[static_cast<Eigen::Index>(kept.size())] = variance * (1.0 / weight - 1.0);
    kept.push_back(channel);
  }
  added_variance_.conservativeResize(static_cast<Eigen::Index>(kept.size()));
  if (changed) innovation.channels = std::move(kept);
  return changed;
}

// Maps the kind of filter to a representation of P and a set of sigma points. The unscented kinds draw points of the
// whole state. The partially linear kinds draw them in the arguments of the nonlinear functions only, which gives the
// same moments of the linear part. Their fast form needs a process matrix with blocks that fit into tiles; otherwise
// the dense filter gives the same estimates. The extended filter is the limit of points with no spread: a first-order
// linearisation.
namespace {

std::unique_ptr<Filter> make_representation(FilterKind kind, const FilterModel& model, const UnscentedOptions& options,
                                            int threads) {
  UnscentedOptions of_arguments = options;
  of_arguments.points = SigmaPoints::of_arguments;
  switch (kind) {
    case FilterKind::unscented:
      return std::make_unique<CovarianceFilter>(model, UnscentedTransform(options));
    case FilterKind::unscented_square_root:
      return std::make_unique<SquareRootFilter>(model, UnscentedTransform(options));
    case FilterKind::partially_linear:
      if (auto layout = tile_layout(model.process.linear()))
        return std::make_unique<PartiallyLinearFilter>(model, options, *std::move(layout), threads);
      return std::make_unique<CovarianceFilter>(model, UnscentedTransform(of_arguments));
    case FilterKind::partially_linear_square_root:
      return std::make_unique<SquareRootFilter>(model, UnscentedTransform(of_arguments));
    case FilterKind::extended:
      return std::make_unique<CovarianceFilter>(model, UnscentedTransform::linearised());
  }
  return {};
}

}  // namespace

std::unique_ptr<Filter> make_filter(FilterKind kind, const FilterModel& model, const UnscentedOptions& options,
                                    int threads) {
  auto filter = make_representation(kind, model, options, threads);
  filter->iterate_updates(options.update_iterations);
  return filter;
}

void whiten(const Eigen::MatrixXd& lower, Eigen::VectorXd& vector) {
  for (Eigen::Index i = 0; i < vector.size(); ++i) {
    for (Eigen::Index k = 0; k < i; ++k) vector[i] -= lower(i, k) * vector[k];
    vector[i] /= lower(i, i);
  }
}

Eigen::MatrixXd gain_from(const Eigen::MatrixXd& whitened_cross, const Eigen::MatrixXd& lower) {
  constexpr Eigen::Index few = 16;  // columns; the general solution prepares blocks, which costs more than they do
  if (lower.cols() > few) return lower.triangularView<Eigen::Lower>().solve<Eigen::OnTheRight>(whitened_cross);
  Eigen::MatrixXd gain = whitened_cross;
  for (Eigen::Index j = gain.cols() - 1; j >= 0; --j) {
    double* column = &gain(0, j);
    for (Eigen::Index k = j + 1; k < gain.cols(); ++k) {
      const double *later = &gain(0, k), factor = lower(k, j);
      KALFEM_INDEPENDENT
      for (Eigen::Index i = 0; i < gain.rows(); ++i) column[i] -= later[i] * factor;
    }
    gain.col(j) *= 1.0 / lower(j, j);
  }
  return gain;
}

// log N(nu; 0, L L^T) = -1/2 (nu^T (L L^T)^-1 nu + log det(L L^T) + l log(2 pi)). Both terms come from the factor:
// the first is the squared norm of L^-1 nu, the second twice the sum of log L_ii.
void score(Innovation& innovation, const Eigen::MatrixXd& factor, const Eigen::VectorXd& whitened) {
  innovation.nis = whitened.squaredNorm();
  const double log_determinant = 2.0 * factor.diagonal().array().log().sum();
  innovation.log_likelihood = -0.5 * (innovation.nis + log_determinant +
                                      static_cast<double>(innovation.value.size()) * std::log(2.0 * std::numbers::pi));
}

}  // namespace kalfem
