// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "kalfem/base/resumable.hpp"
#include "kalfem/estimation/filter.hpp"
#include "kalfem/estimation/partially_linear/projected_covariance.hpp"
#include "kalfem/estimation/partially_linear/projected_map.hpp"

namespace kalfem {

/// Sigma points of the few nonlinear arguments w = N x + e only, and a covariance that moves in O(n^2): for a process
/// model whose A is block diagonal, with U = G and F = L^-T delta the slopes of phi (L L^T = P_ww),
///     P+ = A P A^T + W U^T + U W^T + Q,      W = A P_xw F + G (delta^T delta + Sigma) / 2.
/// The measurement update is P - J J^T with thin J; it waits for the next prediction's pass over P. That pass also
/// forms P H^T for the rows H that update and prediction ask for, so P is read and written once a step. Variances are
/// widened by 1e-13 of themselves before each downdate, which keeps P positive semi-definite.
/// Estimates are those of a covariance filter with SigmaPoints::of_arguments. docs/theory/partially-linear-ukf.md.
class PartiallyLinearFilter final : public Filter, public Resumable {
public:
  /// `layout` is that of the process model's A.
  PartiallyLinearFilter(const FilterModel& model, const UnscentedOptions& options, TileLayout layout, int threads = 1);

  void reset(const Gaussian& estimate) override;
  FilterOutcome predict() override;
  void set_process_noise(const Eigen::MatrixXd& noise) override;
  FilterOutcome observe(Eigen::VectorXd& mean, Eigen::VectorXd* deviation) override;
  Eigen::MatrixXd monitored_with(const std::vector<Eigen::Index>& states) const override;
  void keep(ArchiveWriter& archive) const override { estimate_.keep(archive); }
  void take_up(ArchiveReader& archive) override { estimate_.take_up(archive); }

  Eigen::MatrixXd gain() const override {
    return gain_from(estimate_.downdate()(layout_.slot, Eigen::all), innovation_factor_);
  }
  Eigen::MatrixXd gain_of(const std::vector<Eigen::Index>& states) const override;
  const Eigen::VectorXd& mean() const override;
  Eigen::VectorXd standard_deviation() const override;
  Eigen::MatrixXd covariance() const override { return estimate_.covariance(); }
  Eigen::MatrixXd covariance_of(const std::vector<Eigen::Index>& states) const override {
    return estimate_.covariance_of(states);
  }

private:
  FilterOutcome expect(const Eigen::VectorXd& y, const Eigen::MatrixXd& noise, Innovation& innovation) override;
  FilterOutcome correct(const Eigen::MatrixXd& noise, Innovation& innovation) override;
  void iterate(const Eigen::MatrixXd& noise, Innovation& innovation);
  ProjectedRows rows_of_maps();
  void set_noise_of_propagated();
  void move_gain();
  void propagate_mean();
  void propagate_rows();

  TileLayout layout_;
  TiledPropagator propagator_;    ///< A
  Eigen::MatrixXd gain_;          ///< U, slots x p
  SymmetricTiles process_noise_;  ///< Q

  ProjectedMap process_map_, measurement_map_;
  std::optional<ProjectedMap> monitored_map_;
  ProjectedCovariance estimate_;
  Eigen::MatrixXd gain_of_propagated_;   ///< U^T h^T of the propagated rows, p x such rows
  Eigen::MatrixXd noise_of_propagated_;  ///< Q h^T of these, slots x such rows

  Eigen::MatrixXd force_, response_;                                             ///< P_xf, W, slots x p
  Eigen::MatrixXd predicted_mean_;                                               ///< slots x 1
  Eigen::MatrixXd source_products_, propagated_products_, propagated_response_;  ///< P g^T, P+ h^T; (H W)^T
  Eigen::MatrixXd combination_;                                                  ///< B, then B L^-T
  Eigen::MatrixXd innovation_factor_;
  Eigen::MatrixXd rows_of_downdate_, next_factor_;  ///< of an iterated update: H J; L of the next pass
  Eigen::VectorXd next_value_;
  Eigen::MatrixXd next_covariance_;
  Eigen::MatrixXd monitored_, monitored_products_, monitored_force_;  ///< A^T, P A^T, A P_xf of monitored quantities
  Eigen::VectorXd whitened_, output_mean_;
  mutable Eigen::VectorXd mean_;  ///< x in the order of the states
};

}  // namespace kalfem
