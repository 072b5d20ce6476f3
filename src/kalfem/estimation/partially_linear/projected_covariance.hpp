#pragma once

#include <Eigen/Dense>
#include <vector>

#include "kalfem/estimation/kernels/tile_layout.hpp"

namespace kalfem {

/// Rows of several maps of which each is to be multiplied with a covariance once: equal rows stand once, and rows that
/// pick one state are kept apart, since their products are columns of the covariance. The products stand in the order
/// dense rows, then picked states.
///
/// A dense row h for which another watched row is g = h A needs no product of its own after a prediction by A either:
///     P+ h^T = A (P g^T) + W (U^T h^T) + U (W^T h^T) + Q h^T.
/// The motion at an interval's begin is such a row, that at its end being g. Rows of this kind stand last among the
/// dense ones.
class ProjectedCovariance {
public:
  /// Adds the rows of a matrix over the states; their places are given by `places` after `find_followers`.
  std::size_t add(const Eigen::MatrixXd& rows, const TileLayout& layout);
  /// Finds the rows that follow from others by a prediction; `transposed` is A^T.
  void find_followers(const TiledPropagator& transposed);
  /// Places of the rows of the matrix added as number `matrix` among the products.
  [[nodiscard]] std::vector<Eigen::Index> places(std::size_t matrix) const;

  [[nodiscard]] const Eigen::MatrixXd& dense() const { return dense_; }              ///< slots x dense rows
  [[nodiscard]] const std::vector<Eigen::Index>& single() const { return single_; }  ///< slots of picked states
  [[nodiscard]] const Eigen::MatrixXd& leaders() const { return leaders_; }  ///< dense rows that follow from no other
  [[nodiscard]] const Eigen::MatrixXd& followers() const { return followers_; }  ///< the rest, slots x followers
  /// Places of the rows that the followers follow from.
  [[nodiscard]] const std::vector<Eigen::Index>& followed() const { return followed_; }
  [[nodiscard]] Eigen::Index size() const { return dense_.cols() + static_cast<Eigen::Index>(single_.size()); }

private:
  struct Place {
    bool single;
    Eigen::Index number;
  };
  Place find_or_add(const Eigen::VectorXd& row);

  Eigen::MatrixXd dense_, leaders_, followers_;
  std::vector<Eigen::Index> order_, followed_;  ///< final place of each dense row; of each follower's leader
  std::vector<Eigen::Index> single_;
  std::vector<std::vector<Place>> matrices_;
};

}  // namespace kalfem
