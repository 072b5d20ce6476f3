#pragma once

#include "kalfem/estimation/partially_linear/argument_transform.hpp"
#include "kalfem/estimation/partially_linear/projected_covariance.hpp"

namespace kalfem {

/// One partially linear map seen through the projected covariance H alone: the transform over sigma points of its
/// channels needs no more than the small matrix H [P H^T, x], `gram`, K x (K + 1), whatever the number of states. What
/// it gives are combinations of the columns of P H^T. A map without gain is linear and needs no sigma points. One
/// thread.
class ProjectedMap {
public:
  explicit ProjectedMap(const UnscentedOptions& options) : transform_(options) {}

  [[nodiscard]] bool empty() const { return map_ == nullptr; }
  /// Whether it stands for this map as it is now.
  [[nodiscard]] bool is(const PartiallyLinearMap& map) const { return map_ == &map && revision_ == map.revision; }
  /// Takes the map; `outputs` says that its image is not the state, so that the rows of A are watched too.
  void take(const PartiallyLinearMap& map, bool outputs);
  void add_to(ProjectedCovariance& rows, const TileLayout& layout);
  void find_places(const ProjectedCovariance& rows);

  /// phi over sigma points of w about the mean. False where the covariance of w is not positive semi-definite
  /// (`covariance_usable` says so) or the map cannot be evaluated.
  [[nodiscard]] bool spread(PartiallyLinearMap& map, const Eigen::MatrixXd& gram);
  [[nodiscard]] bool covariance_usable() const { return covariance_usable_; }

  [[nodiscard]] const Eigen::VectorXd& channel_mean() const { return channel_mean_; }  ///< mean(phi), p
  /// F with P_xf = (P H^T) F, F = L^-T delta in the rows of the channels, K x p.
  [[nodiscard]] const Eigen::MatrixXd& slopes() const { return slopes_; }
  /// (delta^T delta + Sigma) / 2, half the covariance of phi, p x p.
  [[nodiscard]] const Eigen::MatrixXd& half_covariance() const { return half_covariance_; }

  // Of outputs y = A x + G phi + b.
  void output_mean(const PartiallyLinearMap& map, const Eigen::MatrixXd& gram, Eigen::VectorXd& y) const;
  /// Adds P_yy to `covariance`, l x l.
  void add_output_covariance(const PartiallyLinearMap& map, const Eigen::MatrixXd& gram, Eigen::MatrixXd& covariance);
  /// B with P_xy = (P H^T) B, K x l.
  void output_cross(const PartiallyLinearMap& map, Eigen::MatrixXd& cross) const;

private:
  const PartiallyLinearMap* map_ = nullptr;
  int revision_ = 0;
  bool outputs_ = false, linear_only_ = false, covariance_usable_ = true;
  std::size_t selection_number_ = 0, linear_number_ = 0;
  std::vector<Eigen::Index> selection_, linear_;  ///< places of the rows of N and A among those watched
  Eigen::Index watched_ = 0;                      ///< K

  ArgumentTransform transform_;
  Eigen::VectorXd centre_, channel_mean_;
  Eigen::MatrixXd covariance_, factor_, channel_slopes_;  ///< P_ww, L, L^-T delta
  Eigen::MatrixXd slopes_, half_covariance_, output_force_;
};

}  // namespace kalfem
