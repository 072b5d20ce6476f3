// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/base/resumable.hpp"
#include "kalfem/estimation/filter.hpp"
#include "kalfem/estimation/iterated_update.hpp"

namespace kalfem {

/// Carries mean and covariance: the UKF of Table 1, or with the linearised transform the EKF.
class CovarianceFilter final : public Filter, public Resumable {
public:
  CovarianceFilter(const FilterModel& model, const UnscentedTransform& transform)
      : Filter(model),
        process_transform_(transform),
        measurement_transform_(transform),
        monitored_transform_(transform) {}

  void reset(const Gaussian& estimate) override;
  FilterOutcome predict() override;
  FilterOutcome observe(Eigen::VectorXd& mean, Eigen::VectorXd* deviation) override;
  Eigen::MatrixXd monitored_with(const std::vector<Eigen::Index>& states) const override {
    return monitored_transform_.deviations() * factor_(states, Eigen::all).transpose();
  }
  void keep(ArchiveWriter& archive) const override;
  void take_up(ArchiveReader& archive) override;

  Eigen::MatrixXd gain() const override { return gain_from(gain_, innovation_factor_); }
  const Eigen::VectorXd& mean() const override { return estimate_.mean; }
  Eigen::VectorXd standard_deviation() const override;
  Eigen::MatrixXd covariance() const override { return estimate_.covariance.selfadjointView<Eigen::Lower>(); }
  Eigen::MatrixXd covariance_of(const std::vector<Eigen::Index>& states) const override;

private:
  FilterOutcome expect(const Eigen::VectorXd& y, const Eigen::MatrixXd& noise, Innovation& innovation) override;
  FilterOutcome correct(const Eigen::MatrixXd& noise, Innovation& innovation) override;
  FilterOutcome transform(PartiallyLinearMap& map, UnscentedTransform& transform);
  void form_innovation(const Eigen::VectorXd& y, const Eigen::MatrixXd& noise, const std::vector<Eigen::Index>& present,
                       Eigen::VectorXd& value, Eigen::MatrixXd& covariance);
  bool iterate(const Eigen::MatrixXd& noise, Innovation& innovation);

  /// One for each size, whose arrays then stay.
  UnscentedTransform process_transform_, measurement_transform_, monitored_transform_;
  Gaussian estimate_;                                                      ///< covariance: lower triangle
  Eigen::MatrixXd factor_, innovation_factor_, gain_, output_covariance_;  ///< gain_: J = P_xy L^-T
  Eigen::VectorXd whitened_;
  IteratedUpdate iterated_;
};

}  // namespace kalfem
