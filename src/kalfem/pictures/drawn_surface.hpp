// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <array>
#include <string>
#include <vector>

#include "kalfem/model/mesh/mesh.hpp"

namespace kalfem {

/// A flat piece that can be drawn: a surface, an outer face of a solid, or a line.
struct DrawnFace {
  std::array<Eigen::Index, 4> nodes = {};  ///< corners, by index
  int count = 0;                           ///< 2: a line
  int region = 0;                          ///< place in the list of regions
};

/// Surfaces, lines and those faces of solids that only one solid of the regions has. Cells that name a corner twice
/// lose it; faces with fewer than three corners are dropped. A cell of several regions is drawn as of the first.
std::vector<DrawnFace> outer_faces(const Mesh& mesh, const std::vector<std::string>& regions);

/// Faces and the places of their corners.
struct DrawnSurface {
  Eigen::Matrix3Xd places;       ///< [m]
  std::vector<DrawnFace> faces;  ///< their nodes are columns of `places`
  bool coarsened = false;
  std::vector<Eigen::Index> place_of = {};  ///< coarsened: per node the column of `places` that it is part of, -1: none
};

/// How much each node tells of the shape: 1 amid a flat part of one region, hundreds to thousands at the edges of faces
/// and where regions meet, more at corners.
Eigen::VectorXd shape_weights(const Eigen::Matrix3Xd& places, const std::vector<DrawnFace>& faces);

/// The same surface in at most about `most` faces: nodes in one box of a grid become one node at their weighted mean,
/// in ever larger boxes, and faces that this flattens or doubles are dropped [RB93].
DrawnSurface coarsened(const Eigen::Matrix3Xd& places, std::vector<DrawnFace> faces, const Eigen::VectorXd& weights,
                       std::size_t most);

}  // namespace kalfem
