// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/base/resumable.hpp"
#include "kalfem/estimation/filter.hpp"
#include "kalfem/estimation/iterated_update.hpp"

namespace kalfem {

/// Carries mean and lower triangular square root S, P = S S^T. Time update and measurement update are orthogonal
/// triangularisations of arrays of columns (Kailath, Sayed and Hassibi, Linear Estimation, chapter 12),
///     [ D  G Sigma^(1/2)  Q^(1/2) ]  ->  [ S+ 0 ],      [ D_y  G Sigma^(1/2)  R^(1/2) ]  ->  [ L_y  0  0 ]
///                                                       [ S        0             0    ]      [ J    S+ 0 ],
/// so that no difference of covariances is ever formed. Only where a negative centre weight makes Sigma indefinite are
/// its negative directions taken off by a downdate that refuses to leave the positive definite matrices.
class SquareRootFilter final : public Filter, public Resumable {
public:
  SquareRootFilter(const FilterModel& model, UnscentedTransform transform);

  void reset(const Gaussian& estimate) override;
  FilterOutcome predict() override;
  void set_process_noise(const Eigen::MatrixXd& noise) override;
  FilterOutcome observe(Eigen::VectorXd& mean, Eigen::VectorXd* deviation) override;
  Eigen::MatrixXd monitored_with(const std::vector<Eigen::Index>& states) const override {
    return transform_.deviations() * factor_(states, Eigen::all).transpose();
  }
  void keep(ArchiveWriter& archive) const override;
  void take_up(ArchiveReader& archive) override;

  Eigen::MatrixXd gain() const override;
  const Eigen::VectorXd& mean() const override { return mean_; }
  Eigen::VectorXd standard_deviation() const override { return factor_.rowwise().norm(); }
  Eigen::MatrixXd covariance() const override { return factor_ * factor_.transpose(); }
  Eigen::MatrixXd covariance_of(const std::vector<Eigen::Index>& states) const override {
    const Eigen::MatrixXd rows = factor_(states, Eigen::all);
    return rows * rows.transpose();
  }

private:
  FilterOutcome expect(const Eigen::VectorXd& y, const Eigen::MatrixXd& noise, Innovation& innovation) override;
  FilterOutcome correct(const Eigen::MatrixXd& noise, Innovation& innovation) override;
  bool split_scatter(const PartiallyLinearMap& map);
  void stack_measurement(const std::vector<Eigen::Index>& present, const Eigen::MatrixXd& noise);
  bool triangularise_measurement(const std::vector<Eigen::Index>& present, const Eigen::MatrixXd& noise);
  bool iterate(const Eigen::MatrixXd& noise, Innovation& innovation);

  UnscentedTransform transform_;
  Eigen::VectorXd mean_;
  Eigen::MatrixXd factor_, array_, triangle_, added_, removed_;
  Eigen::MatrixXd process_root_, noise_root_;  ///< Q^(1/2), R^(1/2) of the measured channels
  Eigen::MatrixXd noise_root_of_;              ///< R that noise_root_ is of
  IteratedUpdate iterated_;
};

}  // namespace kalfem
