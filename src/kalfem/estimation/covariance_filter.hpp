#pragma once

#include "kalfem/estimation/filter.hpp"

namespace kalfem {

/// Carries mean and covariance: the UKF of Table 1, or with the linearised transform the EKF.
class CovarianceFilter final : public Filter {
public:
  explicit CovarianceFilter(const UnscentedTransform& transform)
      : transition_(transform), measurement_(transform), observation_(transform) {}

  void reset(const Gaussian& estimate) override;
  FilterOutcome predict(PartiallyLinearMap& transition, const Eigen::MatrixXd& process_noise) override;
  FilterOutcome update(PartiallyLinearMap& measurement, const Eigen::MatrixXd& noise, const Eigen::VectorXd& y,
                       Innovation& innovation) override;
  FilterOutcome observe(PartiallyLinearMap& map, Eigen::VectorXd& mean, Eigen::VectorXd* deviation) override;

  const Eigen::VectorXd& mean() const override { return estimate_.mean; }
  Eigen::VectorXd standard_deviation() const override;
  Eigen::MatrixXd covariance() const override { return estimate_.covariance.selfadjointView<Eigen::Lower>(); }

private:
  FilterOutcome transform(PartiallyLinearMap& map, UnscentedTransform& transform);

  UnscentedTransform transition_, measurement_, observation_;  ///< one for each size, whose arrays then stay
  Gaussian estimate_;                                          ///< covariance: lower triangle
  Eigen::MatrixXd factor_, innovation_factor_, gain_, output_covariance_;
  Eigen::VectorXd whitened_;
};

}  // namespace kalfem
