#pragma once

#include "kalfem/estimation/filter.hpp"

namespace kalfem {

/// Carries mean and covariance: the UKF of Table 1, or with the linearised transform the EKF.
class CovarianceFilter final : public Filter {
 public:
  explicit CovarianceFilter(UnscentedTransform transform) : transform_(std::move(transform)) {}

  void reset(const Gaussian& estimate) override;
  FilterOutcome predict(PartiallyLinearMap& transition, const Eigen::MatrixXd& process_noise) override;
  FilterOutcome update(PartiallyLinearMap& measurement, const Eigen::MatrixXd& noise, const Eigen::VectorXd& y,
                       Innovation& innovation) override;
  FilterOutcome observe(PartiallyLinearMap& map, Eigen::VectorXd& mean, Eigen::VectorXd& deviation) override;

  const Eigen::VectorXd& mean() const override { return estimate_.mean; }
  Eigen::VectorXd standard_deviation() const override;
  Eigen::MatrixXd covariance() const override { return estimate_.covariance.selfadjointView<Eigen::Lower>(); }

 private:
  FilterOutcome transform(PartiallyLinearMap& map);

  UnscentedTransform transform_;
  Gaussian estimate_;  ///< covariance: lower triangle
  Eigen::MatrixXd factor_, next_covariance_, cross_, gain_;
};

/// NIS and log-likelihood from the innovation and the Cholesky factor of its covariance.
void score(Innovation& innovation, const Eigen::MatrixXd& factor);

}  // namespace kalfem
