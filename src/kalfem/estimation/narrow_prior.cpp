// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/narrow_prior.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Places in the state of the unknowns whose prior is exchanged.
std::vector<Index> narrowed(const AugmentedModel& augmented_model, const Gaussian& prior) {
  std::vector<Index> places;
  const auto& unknowns = augmented_model.options().unknowns;
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const Index place = augmented_model.layout().unknown() + static_cast<Index>(i);
    const bool alone = (prior.covariance.col(place).array() != 0.0).count() == 1;
    if (unknowns[i].random_walk == 0.0 && alone) places.push_back(place);
  }
  return places;
}

/// A normal prior of the constants in the place of another one, both without correlations.
class Exchange {
public:
  Exchange(const VectorXd& from_mean, const VectorXd& from_variance, const VectorXd& to_mean,
           const VectorXd& to_variance)
      : from_mean_(from_mean), from_(from_variance.cwiseInverse()), to_(to_variance.cwiseInverse()) {
    moved_ = to_mean - from_mean;
  }

  /// Mean and covariance under the other prior.
  void apply(VectorXd& mean, MatrixXd& covariance) const {
    const VectorXd told = covariance.llt().solve(mean - from_mean_);
    covariance = (gained(covariance) + MatrixXd(to_.asDiagonal())).llt().solve(MatrixXd::Identity(size(), size()));
    mean = from_mean_ + covariance * (told + to_.cwiseProduct(moved_));
  }

  /// ln p(record) under the other prior less that under this one, of the last mean and covariance under this one.
  [[nodiscard]] double log_likelihood(const VectorXd& mean, const MatrixXd& covariance) const {
    const VectorXd told = covariance.llt().solve(mean - from_mean_), pulled = told + to_.cwiseProduct(moved_);
    const MatrixXd other =
        (gained(covariance) + MatrixXd(to_.asDiagonal())).llt().solve(MatrixXd::Identity(size(), size()));
    const double determinants =
        log_determinant(other) - log_determinant(covariance) + to_.array().log().sum() - from_.array().log().sum();
    return 0.5 * (determinants + pulled.dot(other * pulled) - moved_.dot(to_.cwiseProduct(moved_)) -
                  told.dot(covariance * told));
  }

private:
  [[nodiscard]] Index size() const { return from_.size(); }

  /// The information that the record added: nothing where rounding says that it took some away.
  [[nodiscard]] MatrixXd gained(const MatrixXd& covariance) const {
    const VectorXd scale = from_.cwiseSqrt().cwiseInverse();
    MatrixXd gain = scale.asDiagonal() * covariance.llt().solve(MatrixXd(scale.asDiagonal()));
    gain.diagonal().array() -= 1.0;
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(0.5 * (gain + gain.transpose()));
    const MatrixXd positive =
        eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() * eigen.eigenvectors().transpose();
    return scale.cwiseInverse().asDiagonal() * positive * scale.cwiseInverse().asDiagonal();
  }

  static double log_determinant(const MatrixXd& covariance) {
    return 2.0 * MatrixXd(covariance.llt().matrixL()).diagonal().array().log().sum();
  }

  VectorXd from_mean_, from_, to_, moved_;  ///< informations, and the other mean less this one
};

/// The state's mean and covariance follow what moves the constants, by regression on them.
void move_final_state(const std::vector<Index>& places, const VectorXd& mean, const MatrixXd& covariance,
                      EstimationResult& result) {
  auto last = result.state.mean.col(result.state.mean.cols() - 1);
  MatrixXd& all = result.final_covariance;
  const MatrixXd before = all(places, places);
  const MatrixXd regression = before.llt().solve(all(places, Eigen::all)).transpose();
  const VectorXd moved = mean - last(places);
  if (last.allFinite()) last += regression * moved;
  all += regression * (covariance - before) * regression.transpose();
  all = (0.5 * (all + all.transpose())).eval();
}

}  // namespace

Gaussian narrow_prior(const AugmentedModel& augmented_model, const EstimationResult& last) {
  Gaussian prior = augmented_model.prior();
  const VectorXd end = last.state.mean.col(last.state.mean.cols() - 1);
  for (const Index place : narrowed(augmented_model, prior)) {
    const double variance = narrow_prior_breadth * narrow_prior_breadth * last.final_covariance(place, place);
    if (!(variance < prior.covariance(place, place))) continue;
    prior.mean[place] = end[place];
    prior.covariance(place, place) = variance;
  }
  return prior;
}

void put_back(const Gaussian& stated, const AugmentedModel& augmented_model, EstimationResult& result) {
  const auto places = narrowed(augmented_model, stated);
  auto& history = result.unknowns_history;
  if (places.empty() || result.failure) return;
  const VectorXd from = result.prior.covariance.diagonal()(places), to = stated.covariance.diagonal()(places);
  const Exchange exchange(result.prior.mean(places), from, stated.mean(places), to);
  VectorXd mean = result.state.mean.col(result.state.mean.cols() - 1)(places);
  MatrixXd covariance = result.final_covariance(places, places);
  const double gain = exchange.log_likelihood(mean, covariance);
  result.log_likelihood += gain;
  if (result.log_density.size() > 0) result.log_density[0] += gain;
  exchange.apply(mean, covariance);
  move_final_state(places, mean, covariance, result);
  result.prior = stated;
  if (history.empty() || history.unknowns.size() != places.size()) return;

  const VectorXd before = history.mean.col(0);
  const Index first = augmented_model.layout().unknown(), samples = result.state.mean.cols();
  for (Index point = 1; point < history.points(); ++point) {
    mean = history.mean.col(point);
    covariance = history.covariance_at(point);
    exchange.apply(mean, covariance);
    history.mean.col(point) = mean;
    history.covariance_at(point) = covariance;
    const Index end = std::min(point * history.stride, samples);
    for (Index k = (point - 1) * history.stride; k < end; ++k)
      for (std::size_t i = 0; i < places.size(); ++i) {
        const auto row = static_cast<Index>(i);
        const auto& transform =
            augmented_model.options().unknowns[static_cast<std::size_t>(history.unknowns[i])].transform;
        const double deviation = std::sqrt(covariance(row, row));
        result.state.mean(places[i], k) = mean[row];
        result.state.deviation(places[i], k) = deviation;
        result.unknowns.mean(places[i] - first, k) = transform.to_parameter(mean[row]);
        result.unknowns.deviation(places[i] - first, k) = transform.slope(mean[row]) * deviation;
      }
  }
  history.mean.col(0) = stated.mean(places);
  history.covariance_at(0) = stated.covariance(places, places);
  for (Index k = 0; k < history.samples_with_slopes(); ++k)
    history.at_prior.col(k) += history.slope_at(k).transpose() * (before - history.mean.col(0));
}

}  // namespace kalfem
