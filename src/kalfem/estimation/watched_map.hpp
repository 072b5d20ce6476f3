#pragma once

#include "kalfem/estimation/channel_transform.hpp"
#include "kalfem/estimation/watched_rows.hpp"

namespace kalfem {

/// One partially linear map in the slots of a tiled covariance, and its transform over sigma points of its channels.
/// With P N^T and, for outputs, P A^T among the watched products it costs O(n). One thread.
class WatchedMap {
public:
  explicit WatchedMap(const UnscentedOptions& options) : transform_(options) {}

  /// Whether it stands for this map as it is now.
  [[nodiscard]] bool is(const PartiallyLinearMap& map) const { return map_ == &map && revision_ == map.revision; }
  [[nodiscard]] bool empty() const { return map_ == nullptr; }
  /// Takes the map's N and, where its image is outputs and not the state, A; adds their rows to those watched.
  void take(const PartiallyLinearMap& map, bool outputs, const TileLayout& layout);
  void add_to(WatchedRows& rows, const TileLayout& layout);
  void find_places(const WatchedRows& rows);

  /// phi over sigma points of w about the mean, slots x 1. False where the covariance of w is not positive
  /// semi-definite (`covariance_usable` says so) or the map cannot be evaluated.
  [[nodiscard]] bool spread(PartiallyLinearMap& map, const Eigen::MatrixXd& mean, const Eigen::MatrixXd& products);
  [[nodiscard]] bool covariance_usable() const { return covariance_usable_; }

  [[nodiscard]] const Eigen::VectorXd& channel_mean() const { return transform_.mean(); }  ///< mean(phi), p
  [[nodiscard]] const Eigen::MatrixXd& cross() const { return force_; }                    ///< P_xf, slots x p
  /// delta^T delta + Sigma, the covariance of phi, p x p.
  [[nodiscard]] const Eigen::MatrixXd& channel_covariance() const { return force_covariance_; }

  // Of outputs y = A x + G phi + b.
  void output_mean(const PartiallyLinearMap& map, const Eigen::MatrixXd& mean, Eigen::VectorXd& y);
  /// P_xy = P A^T + P_xf G^T, slots x l.
  void output_cross(const PartiallyLinearMap& map, const Eigen::MatrixXd& products, Eigen::MatrixXd& cross);
  /// Adds A P A^T + A P_xf G^T + G P_xf^T A^T + G P_ff G^T, l x l.
  void add_output_covariance(const PartiallyLinearMap& map, const Eigen::MatrixXd& products,
                             Eigen::MatrixXd& covariance);

private:
  struct Selected {
    Eigen::Index channel, slot;
  };

  const PartiallyLinearMap* map_ = nullptr;
  int revision_ = 0;
  bool outputs_ = false, covariance_usable_ = true;
  std::size_t selection_number_ = 0, linear_number_ = 0;
  std::vector<Eigen::Index> selection_places_, linear_places_;
  Eigen::MatrixXd dense_selection_;           ///< rows of N that are not single states, slots x q_d
  std::vector<Eigen::Index> dense_channels_;  ///< their channels
  std::vector<Selected> single_channels_;     ///< channels that are single states
  Eigen::MatrixXd linear_;                    ///< rows of A, slots x l

  ChannelTransform transform_;
  Eigen::VectorXd centre_;
  Eigen::MatrixXd channel_cross_;                 ///< P_xw, slots x q
  Eigen::MatrixXd covariance_, factor_, slopes_;  ///< P_ww, L, F = L^-T delta
  Eigen::MatrixXd force_, force_covariance_;
  Eigen::MatrixXd dense_covariance_, dense_centre_;
  Eigen::MatrixXd output_of_mean_, output_products_, output_covariance_, output_force_;
};

}  // namespace kalfem
