// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/estimation/iterated_update.hpp"
#include "kalfem/estimation/partially_linear/argument_transform.hpp"
#include "kalfem/estimation/partially_linear/projected_rows.hpp"

namespace kalfem {

/// One partially linear map seen through the projected rows H alone: the transform over sigma points of its arguments
/// needs no more than the small matrix H [P H^T, x], `gram`, K x (K + 1), whatever the number of states. What it gives
/// are combinations of the columns of P H^T. A map without gain is linear and needs no sigma points. One thread.
class ProjectedMap {
public:
  ProjectedMap(PartiallyLinearMap& map, const UnscentedOptions& options) : map_(map), transform_(options) {}

  // Once, before anything else. `outputs` says that the map's image is not the state, so that the rows of A are
  // projected too.
  void add_to(ProjectedRows& rows, const TileLayout& layout, bool outputs);
  void find_places(const ProjectedRows& rows);

  /// phi over sigma points of w about the mean. False where the covariance of w is not positive semi-definite
  /// (`covariance_usable` says so) or the map cannot be evaluated.
  [[nodiscard]] bool spread(const Eigen::MatrixXd& gram);
  /// The same for nonlinear_mean() alone.
  [[nodiscard]] bool spread_mean(const Eigen::MatrixXd& gram);
  /// The same over sigma points of the posterior with the gram matrix `gram` - J [J; -v^T]^T, J being K x l, brought
  /// back to the prior `gram`: with phi ~ mean(phi) + F^T (w - mean(w)) + error of covariance Sigma there, the mean and
  /// the covariance of phi are those which this gives to the prior's w. For iterated updates, IteratedUpdate.
  [[nodiscard]] bool spread_about(const Eigen::MatrixXd& gram, const Eigen::MatrixXd& downdate,
                                  const Eigen::VectorXd& whitened);
  /// Before the passes of an update, and whether the arguments have stopped moving since the pass before,
  /// ArgumentMoves.
  void begin_passes() { moves_.restart(); }
  [[nodiscard]] bool settled();
  /// Whether further passes of an update would repeat the first.
  [[nodiscard]] bool is_linear() const { return linear_only_; }
  [[nodiscard]] bool covariance_usable() const { return covariance_usable_; }

  [[nodiscard]] const Eigen::VectorXd& nonlinear_mean() const { return nonlinear_mean_; }  ///< mean(phi), p
  /// F with P_xf = (P H^T) F, F = L^-T delta in the rows of the arguments, K x p.
  [[nodiscard]] const Eigen::MatrixXd& slopes() const { return slopes_; }
  /// (delta^T delta + Sigma) / 2, half the covariance of phi, p x p.
  [[nodiscard]] const Eigen::MatrixXd& half_covariance() const { return half_covariance_; }

  // Of outputs y = A x + G phi + b: the l of these channels, after select_channels().
  void select_channels(const std::vector<Eigen::Index>& channels);
  void output_mean(const Eigen::MatrixXd& gram, Eigen::VectorXd& y) const;
  /// Adds P_yy to `covariance`, l x l.
  void add_output_covariance(const Eigen::MatrixXd& gram, Eigen::MatrixXd& covariance);
  /// B with P_xy = (P H^T) B, K x l.
  void output_cross(Eigen::MatrixXd& cross) const;

private:
  void take_arguments(const Eigen::MatrixXd& gram);
  bool evaluate_arguments();
  void set_covariances();

  PartiallyLinearMap& map_;
  bool outputs_ = false, linear_only_ = false, covariance_usable_ = true;
  std::size_t selection_number_ = 0, linear_number_ = 0;
  std::vector<Eigen::Index> selection_, linear_;  ///< places of the rows of N and A among the projected rows
  Eigen::Index rows_ = 0;                         ///< K

  ArgumentTransform transform_;
  Eigen::VectorXd centre_, nonlinear_mean_;
  Eigen::MatrixXd covariance_, factor_, argument_slopes_transposed_;     ///< P_ww, L, F^T of the arguments
  Eigen::MatrixXd prior_covariance_, argument_slopes_, prior_products_;  ///< P_ww, F, P_ww F of an iterated update
  Eigen::VectorXd prior_centre_, deviation_;
  ArgumentMoves moves_;
  std::vector<Eigen::Index> independent_;  ///< arguments of the columns of L
  Eigen::Index directions_ = 0;            ///< the most columns of L until now
  Eigen::MatrixXd slopes_, half_covariance_, output_force_;
  std::vector<Eigen::Index> places_;  ///< of the selected channels' rows of A
  Eigen::MatrixXd gain_;              ///< G of these, l x p
  Eigen::VectorXd offset_;            ///< b of these, l
};

}  // namespace kalfem
