#pragma once

#include <Eigen/Dense>
#include <vector>

#include "kalfem/estimation/tile_layout.hpp"

namespace kalfem {

/// Rows of several maps of which each is to be multiplied with a covariance once: equal rows stand once, and rows that
/// pick one state are kept apart, since their products are columns of the covariance. The products stand in the order
/// dense rows, then picked states.
class WatchedRows {
public:
  /// Adds the rows of a matrix over the states; their places are given by `places` after the last call of add.
  std::size_t add(const Eigen::MatrixXd& rows, const TileLayout& layout);
  /// Places of the rows of the matrix added as number `matrix` among the products.
  [[nodiscard]] std::vector<Eigen::Index> places(std::size_t matrix) const;

  [[nodiscard]] const Eigen::MatrixXd& dense() const { return dense_; }              ///< slots x dense rows
  [[nodiscard]] const std::vector<Eigen::Index>& single() const { return single_; }  ///< slots of picked states
  [[nodiscard]] Eigen::Index size() const { return dense_.cols() + static_cast<Eigen::Index>(single_.size()); }

private:
  struct Place {
    bool single;
    Eigen::Index number;
  };
  Place find_or_add(const Eigen::VectorXd& row);

  Eigen::MatrixXd dense_;
  std::vector<Eigen::Index> single_;
  std::vector<std::vector<Place>> matrices_;
};

}  // namespace kalfem
