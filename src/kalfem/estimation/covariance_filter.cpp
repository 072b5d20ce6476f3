#include "kalfem/estimation/covariance_filter.hpp"

#include <cmath>
#include <numbers>

#include "kalfem/estimation/covariance_factor.hpp"

namespace kalfem {

void CovarianceFilter::reset(const Gaussian& estimate) { estimate_ = estimate; }

FilterOutcome CovarianceFilter::transform(PartiallyLinearMap& map) {
  if (!covariance_factor(estimate_.covariance, factor_)) return FilterOutcome::covariance_not_positive_definite;
  return transform_.apply(map, estimate_.mean, factor_) ? FilterOutcome::usable : FilterOutcome::model_not_evaluable;
}

FilterOutcome CovarianceFilter::predict(PartiallyLinearMap& transition, const Eigen::MatrixXd& process_noise) {
  if (const auto outcome = transform(transition); outcome != FilterOutcome::usable) return outcome;
  estimate_.mean = transform_.mean();
  estimate_.covariance = process_noise;
  transform_.add_covariance(transition, estimate_.covariance);
  return FilterOutcome::usable;
}

FilterOutcome CovarianceFilter::update(PartiallyLinearMap& measurement, const Eigen::MatrixXd& noise,
                                       const Eigen::VectorXd& y, Innovation& innovation) {
  if (const auto outcome = transform(measurement); outcome != FilterOutcome::usable) return outcome;
  innovation.value = y - transform_.mean();
  innovation.covariance = noise;
  transform_.add_covariance(measurement, innovation.covariance);
  const Eigen::LLT<Eigen::MatrixXd> innovation_factor(innovation.covariance);
  if (innovation_factor.info() != Eigen::Success) return FilterOutcome::innovation_not_positive_definite;

  // K P_yy = P_xy; with P_yy = L L^T and J = P_xy L^-T the update is x + J (L^-1 nu), P - J J^T.
  cross_.noalias() = factor_ * transform_.deviations().transpose();
  gain_ = innovation_factor.matrixL().solve(cross_.transpose()).transpose();
  estimate_.mean.noalias() += gain_ * innovation_factor.matrixL().solve(innovation.value);
  estimate_.covariance.selfadjointView<Eigen::Lower>().rankUpdate(gain_, -1.0);
  score(innovation, innovation_factor.matrixL());
  return FilterOutcome::usable;
}

FilterOutcome CovarianceFilter::observe(PartiallyLinearMap& map, Eigen::VectorXd& mean, Eigen::VectorXd& deviation) {
  if (const auto outcome = transform(map); outcome != FilterOutcome::usable) return outcome;
  mean = transform_.mean();
  next_covariance_.setZero(mean.size(), mean.size());
  transform_.add_covariance(map, next_covariance_);
  deviation = next_covariance_.diagonal().cwiseMax(0.0).cwiseSqrt();
  return FilterOutcome::usable;
}

Eigen::VectorXd CovarianceFilter::standard_deviation() const {
  return estimate_.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
}

void score(Innovation& innovation, const Eigen::MatrixXd& factor) {
  innovation.nis = factor.triangularView<Eigen::Lower>().solve(innovation.value).squaredNorm();
  const double log_determinant = 2.0 * factor.diagonal().array().log().sum();
  innovation.log_likelihood =
      -0.5 * (innovation.nis + log_determinant +
              static_cast<double>(innovation.value.size()) * std::log(2.0 * std::numbers::pi));
}

}  // namespace kalfem
