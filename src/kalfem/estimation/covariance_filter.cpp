#include "kalfem/estimation/covariance_filter.hpp"

#include "kalfem/estimation/covariance_factor.hpp"
#include "kalfem/estimation/kernels/small_kernels.hpp"

namespace kalfem {

void CovarianceFilter::reset(const Gaussian& estimate) { estimate_ = estimate; }

FilterOutcome CovarianceFilter::transform(PartiallyLinearMap& map, UnscentedTransform& transform) {
  if (!covariance_factor(estimate_.covariance, factor_)) return FilterOutcome::covariance_not_positive_definite;
  return transform.apply(map, estimate_.mean, factor_, FactorShape::lower_triangular)
             ? FilterOutcome::usable
             : FilterOutcome::model_not_evaluable;
}

FilterOutcome CovarianceFilter::predict(PartiallyLinearMap& transition, const Eigen::MatrixXd& process_noise) {
  if (const auto outcome = transform(transition, transition_); outcome != FilterOutcome::usable) return outcome;
  estimate_.mean = transition_.mean();
  estimate_.covariance = process_noise;
  transition_.add_covariance(transition, estimate_.covariance);
  return FilterOutcome::usable;
}

FilterOutcome CovarianceFilter::update(PartiallyLinearMap& measurement, const Eigen::MatrixXd& noise,
                                       const Eigen::VectorXd& y, Innovation& innovation) {
  if (const auto outcome = transform(measurement, measurement_); outcome != FilterOutcome::usable) return outcome;
  innovation.value = y - measurement_.mean();
  innovation.covariance = noise;
  measurement_.add_covariance(measurement, innovation.covariance);
  if (!cholesky(innovation.covariance, 0.0, innovation_factor_)) return FilterOutcome::innovation_not_positive_definite;

  // K P_yy = P_xy; with P_yy = L L^T and J = P_xy L^-T the update is x + J (L^-1 nu), P - J J^T.
  multiply_transposed(factor_, measurement_.deviations(), gain_);
  solve_on_the_right(innovation_factor_, gain_);
  whitened_ = innovation.value;
  whiten(innovation_factor_, whitened_);
  estimate_.mean.noalias() += gain_.lazyProduct(whitened_);
  estimate_.covariance.diagonal() *= 1.0 + rounding_allowance;
  subtract_square(gain_, estimate_.covariance);
  score(innovation, innovation_factor_, whitened_);
  return FilterOutcome::usable;
}

FilterOutcome CovarianceFilter::observe(PartiallyLinearMap& map, Eigen::VectorXd& mean, Eigen::VectorXd* deviation) {
  if (const auto outcome = transform(map, observation_); outcome != FilterOutcome::usable) return outcome;
  mean = observation_.mean();
  if (!deviation) return FilterOutcome::usable;
  output_covariance_.setZero(mean.size(), mean.size());
  observation_.add_covariance(map, output_covariance_);
  *deviation = output_covariance_.diagonal().cwiseMax(0.0).cwiseSqrt();
  return FilterOutcome::usable;
}

Eigen::VectorXd CovarianceFilter::standard_deviation() const {
  return estimate_.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
}

}  // namespace kalfem
