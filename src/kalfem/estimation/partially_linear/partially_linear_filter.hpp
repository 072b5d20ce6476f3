#pragma once

#include "kalfem/estimation/filter.hpp"
#include "kalfem/estimation/partially_linear/covariance_tiles.hpp"
#include "kalfem/estimation/partially_linear/projected_map.hpp"

namespace kalfem {

/// Sigma points of the few channels w = N x + e only, and a covariance that moves in O(n^2): for a transition whose A
/// is block diagonal, with U = G and F = L^-T delta the slopes of phi (L L^T = P_ww),
///     P+ = A P A^T + W U^T + U W^T + Q,      W = A P_xw F + G (delta^T delta + Sigma) / 2.
/// The measurement update is P - J J^T with thin J; it waits for the next prediction's pass over P. That pass also
/// forms P H^T for the rows H that update and prediction ask for, so P is read and written once a step. Variances are
/// widened by 1e-13 of themselves before each downdate, which keeps P positive semi-definite.
/// Estimates are those of a covariance filter with SigmaPoints::of_channels. docs/theory/partially-linear-ukf.md.
class PartiallyLinearFilter final : public Filter {
public:
  /// `layout` is that of transition.linear; predictions are by that map (its b, e and moving gain may change).
  PartiallyLinearFilter(const UnscentedOptions& options, const PartiallyLinearMap& transition, TileLayout layout,
                        int threads = 1);

  void reset(const Gaussian& estimate) override;
  /// Q is read again when it is another matrix than last time or its diagonal has changed.
  FilterOutcome predict(PartiallyLinearMap& transition, const Eigen::MatrixXd& process_noise) override;
  FilterOutcome update(PartiallyLinearMap& measurement, const Eigen::MatrixXd& noise, const Eigen::VectorXd& y,
                       Innovation& innovation) override;
  FilterOutcome observe(PartiallyLinearMap& map, Eigen::VectorXd& mean, Eigen::VectorXd* deviation) override;

  const Eigen::VectorXd& mean() const override;
  Eigen::VectorXd standard_deviation() const override;
  Eigen::MatrixXd covariance() const override;

private:
  void watch(ProjectedMap& watched, const PartiallyLinearMap& map);
  void refresh();
  void follow();
  void move_gain(const PartiallyLinearMap& transition);
  void complete_products();
  void read_process_noise(const Eigen::MatrixXd& process_noise);

  TileLayout layout_;
  TiledPropagator propagator_, transposed_;  ///< A, A^T
  Eigen::MatrixXd gain_;                     ///< U, slots x p
  SymmetricTiles process_noise_;
  const Eigen::MatrixXd* process_noise_source_ = nullptr;
  Eigen::VectorXd process_noise_diagonal_;

  CovarianceTiles covariance_;
  Eigen::MatrixXd mean_;      ///< slots x 1
  Eigen::MatrixXd downdate_;  ///< J of an update that waits for the next pass, slots x l
  bool pending_ = false;      ///< whether there is one

  ProjectedMap transition_, measurement_, observation_;
  ProjectedCovariance rows_;            ///< H, K rows
  bool rows_ready_ = false;             ///< whether these are the rows of the maps as they are
  Eigen::MatrixXd products_;            ///< [P H^T, x] after what is pending, slots x (K + 1)
  Eigen::MatrixXd gram_;                ///< H [P H^T, x], K rows, then zeros to a multiple of eight, x (K + 1)
  bool fresh_ = false;                  ///< whether they belong to the estimate
  Eigen::MatrixXd gain_of_followers_;   ///< U^T h^T of the rows that follow, p x followers
  Eigen::MatrixXd noise_of_followers_;  ///< Q H^T of these, slots x followers

  Eigen::MatrixXd force_, response_;                              ///< P_xf, W, slots x p
  Eigen::MatrixXd followed_, following_, response_of_followers_;  ///< P g^T, P+ h^T, slots x followers; (H W)^T
  Eigen::MatrixXd cross_, rows_of_downdate_, rows_and_score_;     ///< B, H J, [H J; -(L^-1 nu)^T]
  Eigen::MatrixXd innovation_factor_;
  Eigen::MatrixXd observed_, observed_products_, observed_force_;  ///< A^T, P A^T, A P_xf of outputs looked at
  Eigen::VectorXd whitened_, output_mean_;
  mutable Eigen::VectorXd state_mean_;
};

}  // namespace kalfem
