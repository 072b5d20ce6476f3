// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/history_keeper.hpp"

#include <limits>

#include "kalfem/estimation/kernels/small_kernels.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr Index largest_history = 10'000'000;  ///< numbers of the covariances over a record

}  // namespace

std::vector<Index> constant_states(const AugmentedModel& augmented_model) {
  const auto& unknowns = augmented_model.options().unknowns;
  std::vector<Index> states;
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    if (unknowns[i].random_walk == 0.0) states.push_back(augmented_model.layout().unknown() + static_cast<Index>(i));
  return states;
}

HistoryKeeper::HistoryKeeper(const AugmentedModel& augmented_model, const Gaussian& prior, Index samples,
                             Index channels)
    : samples_(samples), states_(constant_states(augmented_model)) {
  for (const Index state : states_) history_.unknowns.push_back(state - augmented_model.layout().unknown());
  const Index count = std::ssize(states_);
  history_.stride = 1 + samples * count * count / largest_history;
  const Index most = 2 + samples / history_.stride;  // the prior, the multiples of the stride and the last sample
  history_.mean.resize(count, most);
  history_.covariance.resize(count, count * most);
  history_.mean.col(0) = prior.mean(states_);
  history_.covariance.leftCols(count) = prior.covariance(states_, states_);
  points_ = 1;
  keeps_slopes_ = count > 0 && samples * channels * count <= largest_history;
  if (!keeps_slopes_) return;
  history_.at_prior = history_.deviation =
      MatrixXd::Constant(channels, samples, std::numeric_limits<double>::quiet_NaN());
  history_.slope = MatrixXd::Zero(count, channels * samples);
}

void HistoryKeeper::keep(Index k, const Filter& filter, const Innovation& innovation) {
  const bool is_point = (k + 1) % history_.stride == 0 || k + 1 == samples_;
  if (!keeps_slopes_ && !is_point) return;
  covariance_ = filter.covariance_of(states_);
  if (keeps_slopes_) keep_slope(k, filter, innovation);
  if (is_point) keep_point(filter);
}

void HistoryKeeper::keep_point(const Filter& filter) {
  history_.mean.col(points_) = filter.mean()(states_);
  history_.covariance_at(points_) = covariance_;
  ++points_;
}

/// What a filter that knows the constants would see, from the gain K of the update just made: P_theta,y = K S, and the
/// covariance before it is that after it and K S K^T.
void HistoryKeeper::keep_slope(Index k, const Filter& filter, const Innovation& innovation) {
  slopes_ = k + 1;
  const auto& channels = innovation.channels;
  if (channels.empty()) return;
  gain_ = filter.gain_of(states_);
  innovation_covariance_ = innovation.conditioned_covariance().selfadjointView<Eigen::Lower>();
  cross_.noalias() = innovation_covariance_.lazyProduct(gain_.transpose());
  before_ = covariance_;
  before_.noalias() += gain_.lazyProduct(cross_);
  if (!cholesky(before_, 0.0, factor_)) return;
  whitened_ = cross_;
  solve_on_the_right(factor_, whitened_);
  slope_ = gain_from(whitened_, factor_);
  history_.slope_at(k)(Eigen::all, channels) = slope_.transpose();
  moved_ = filter.mean()(states_) - history_.mean.col(0);
  moved_.noalias() -= gain_.lazyProduct(innovation.conditioned_value());
  known_ = innovation_covariance_.diagonal() - whitened_.rowwise().squaredNorm();
  history_.at_prior(channels, k) = innovation.conditioned_value() + slope_.lazyProduct(moved_);
  history_.deviation(channels, k) = known_.cwiseMax(0.0).cwiseSqrt();
}

UnknownsHistory HistoryKeeper::take() {
  history_.mean.conservativeResize(Eigen::NoChange, points_);
  history_.covariance.conservativeResize(Eigen::NoChange, points_ * history_.mean.rows());
  history_.slope.conservativeResize(Eigen::NoChange, slopes_ * history_.at_prior.rows());
  return std::move(history_);
}

}  // namespace kalfem
