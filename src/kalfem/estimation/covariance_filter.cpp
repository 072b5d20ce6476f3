// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/covariance_filter.hpp"

#include <algorithm>

#include "kalfem/estimation/covariance_factor.hpp"
#include "kalfem/estimation/kernels/small_kernels.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

void CovarianceFilter::reset(const Gaussian& estimate) { estimate_ = estimate; }

// Every transform starts from a fresh square root S of P, lower triangular. A covariance that is not positive
// semi-definite ends here, before any sigma point is evaluated.
FilterOutcome CovarianceFilter::transform(PartiallyLinearMap& map, UnscentedTransform& transform) {
  if (!covariance_factor(estimate_.covariance, factor_)) return FilterOutcome::covariance_not_positive_definite;
  return transform.apply(map, estimate_.mean, factor_, FactorShape::lower_triangular)
             ? FilterOutcome::usable
             : FilterOutcome::model_not_evaluable;
}

/// m <- mean(f), P <- P_ff + Q.
FilterOutcome CovarianceFilter::predict() {
  if (const auto outcome = transform(process(), process_transform_); outcome != FilterOutcome::usable) return outcome;
  estimate_.mean = process_transform_.mean();
  copy(process_noise(), estimate_.covariance);
  process_transform_.add_covariance(process(), estimate_.covariance);
  return FilterOutcome::usable;
}

FilterOutcome CovarianceFilter::expect(const VectorXd& y, const MatrixXd& noise, Innovation& innovation) {
  if (const auto outcome = transform(measurement(), measurement_transform_); outcome != FilterOutcome::usable)
    return outcome;
  form_innovation(y, noise, innovation.channels, innovation.value, innovation.covariance);
  return FilterOutcome::usable;
}

FilterOutcome CovarianceFilter::correct(const MatrixXd& noise, Innovation& innovation) {
  if (!cholesky(innovation.covariance, 0.0, innovation_factor_)) return FilterOutcome::innovation_not_positive_definite;

  // K P_yy = P_xy; with P_yy = L L^T and J = P_xy L^-T the update is x + J (L^-1 nu), P - J J^T.
  whitened_ = innovation.value;
  whiten(innovation_factor_, whitened_);
  score(innovation, innovation_factor_, whitened_);
  if (update_iterations() > 1 && !iterate(noise, innovation)) return FilterOutcome::innovation_not_positive_definite;
  solve_on_the_right(innovation_factor_, gain_);
  estimate_.mean.noalias() += gain_.lazyProduct(whitened_);
  estimate_.covariance.diagonal() *= 1.0 + rounding_allowance;
  subtract_square(gain_, estimate_.covariance);
  return FilterOutcome::usable;
}

/// The same innovation and gain about the posterior. The innovation that is scored stays the prediction's.
bool CovarianceFilter::iterate(const MatrixXd& noise, Innovation& innovation) {
  iterated_.refine({measurement(), estimate_.mean, factor_, innovation.channels, measured_values(), noise},
                   update_iterations(), measurement_transform_);
  auto& [value, covariance] = innovation.about_posterior;
  form_innovation(measured_values(), noise, innovation.channels, value, covariance);
  innovation.relinearised = true;
  if (!cholesky(covariance, 0.0, innovation_factor_)) return false;
  whitened_ = value;
  whiten(innovation_factor_, whitened_);
  return true;
}

/// nu, P_yy + R and P_xy = S D^T of the measured channels from the transform of all of them.
void CovarianceFilter::form_innovation(const VectorXd& y, const MatrixXd& noise, const std::vector<Index>& present,
                                       VectorXd& value, MatrixXd& covariance) {
  covariance = noise;
  if (y.size() == channels()) {
    value = y - measurement_transform_.mean();
    measurement_transform_.add_covariance(measurement(), covariance);
    multiply_transposed(factor_, measurement_transform_.deviations(), gain_);
    return;
  }
  value = y - measurement_transform_.mean()(present);
  output_covariance_.setZero(channels(), channels());
  measurement_transform_.add_covariance(measurement(), output_covariance_);
  covariance += output_covariance_(present, present);
  multiply_transposed(factor_, measurement_transform_.deviations()(present, Eigen::all), gain_);
}

FilterOutcome CovarianceFilter::observe(VectorXd& mean, VectorXd* deviation) {
  if (const auto outcome = transform(monitored(), monitored_transform_); outcome != FilterOutcome::usable)
    return outcome;
  mean = monitored_transform_.mean();
  if (!deviation) return FilterOutcome::usable;
  output_covariance_.setZero(mean.size(), mean.size());
  monitored_transform_.add_covariance(monitored(), output_covariance_);
  *deviation = output_covariance_.diagonal().cwiseMax(0.0).cwiseSqrt();
  return FilterOutcome::usable;
}

void CovarianceFilter::keep(ArchiveWriter& archive) const {
  archive(estimate_.mean);
  archive(estimate_.covariance);
}

void CovarianceFilter::take_up(ArchiveReader& archive) {
  archive(estimate_.mean);
  archive(estimate_.covariance);
}

VectorXd CovarianceFilter::standard_deviation() const {
  return estimate_.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
}

// The updates keep only the lower triangle of P up to date, so each entry is read below the diagonal.
MatrixXd CovarianceFilter::covariance_of(const std::vector<Index>& states) const {
  const auto count = static_cast<Index>(states.size());
  return MatrixXd::NullaryExpr(count, count, [&](Index i, Index j) {
    const auto [column, row] = std::minmax(states[static_cast<std::size_t>(i)], states[static_cast<std::size_t>(j)]);
    return estimate_.covariance(row, column);
  });
}

}  // namespace kalfem
