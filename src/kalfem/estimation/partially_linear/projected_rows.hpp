// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "kalfem/estimation/kernels/tile_layout.hpp"

namespace kalfem {

/// The rows H of several maps whose products with a covariance a filter needs at every step, each of them once: equal
/// rows stand once, and rows that pick one state are kept apart, since their products are columns of the covariance.
/// The products stand in the order direct rows, propagated rows, picked states.
///
/// A propagated row h is one for which another row of H is g = h A. It needs no product with the covariance after a
/// prediction by A:
///     P+ h^T = A (P g^T) + W (U^T h^T) + U (W^T h^T) + Q h^T.
/// The motion at an interval's start is such a row, that at its end being g. The other rows are direct ones.
class ProjectedRows {
public:
  /// Adds the rows of a matrix over the states; their places are given by `places` after `find_propagated`.
  std::size_t add(const Eigen::MatrixXd& rows, const TileLayout& layout);
  /// Tells the propagated rows from the direct ones; `transposed` is A^T.
  void find_propagated(const TiledPropagator& transposed);
  /// Places of the rows of the matrix added as number `matrix` among the products.
  [[nodiscard]] std::vector<Eigen::Index> places(std::size_t matrix) const;

  [[nodiscard]] const Eigen::MatrixXd& dense() const { return dense_; }    ///< slots x direct and propagated rows
  [[nodiscard]] const Eigen::MatrixXd& direct() const { return direct_; }  ///< slots x direct rows
  [[nodiscard]] const Eigen::MatrixXd& propagated() const { return propagated_; }  ///< slots x propagated rows
  /// Places of the rows g of the propagated rows.
  [[nodiscard]] const std::vector<Eigen::Index>& sources() const { return sources_; }
  [[nodiscard]] const std::vector<Eigen::Index>& picked() const { return picked_; }  ///< slots of picked states
  [[nodiscard]] Eigen::Index size() const { return dense_.cols() + static_cast<Eigen::Index>(picked_.size()); }

private:
  struct Place {
    bool picked;
    Eigen::Index number;
  };
  Place find_or_add(const Eigen::VectorXd& row);

  Eigen::MatrixXd dense_, direct_, propagated_;
  std::vector<Eigen::Index> order_, sources_;  ///< final place of each dense row; of each propagated row's g
  std::vector<Eigen::Index> picked_;
  std::vector<std::vector<Place>> matrices_;
};

}  // namespace kalfem
