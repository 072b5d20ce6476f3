// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "kalfem/model/mesh/mesh.hpp"

namespace kalfem {

/// A place in a cell, in natural coordinates of the shape with the cell's corners alone: r of a line and r, s of a
/// quadrilateral in [-1, 1], r and s of a triangle as of a wedge; of solids see solid_shape_functions().
struct CellPlace {
  Eigen::Index cell = 0;
  Eigen::Vector3d natural = Eigen::Vector3d::Zero();
  double distance = 0.0;  ///< from the place that was asked for [m]
};

/// Shares of the corners in a value that is linear between them, sum_i N_i v_i; their sum is 1.
Eigen::VectorXd corner_shares(CellShape shape, const Eigen::Vector3d& natural);

/// Natural coordinates of the centre.
Eigen::Vector3d natural_centre(CellShape shape);

/// The nearest place of each of the cells that are nearest to `place` [m]: one, or all that meet there, in the order
/// of `cells`. Cells are taken by their corners. Empty where there are no cells.
std::vector<CellPlace> nearest_places(const Mesh& mesh, std::span<const Eigen::Index> cells,
                                      const Eigen::Vector3d& place);

}  // namespace kalfem
