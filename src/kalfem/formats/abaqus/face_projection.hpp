#pragma once

#include "kalfem/formats/abaqus/surfaces.hpp"

namespace kalfem::abaqus {

/// The point of a face nearest to a place.
struct Projection {
  Eigen::VectorXd shares;                              ///< shape functions of the face's nodes there
  Eigen::Matrix<double, 3, Eigen::Dynamic> gradients;  ///< of the shape functions, along the surface [1/m]
  Eigen::Vector3d point, normal;
  double distance = 0.0;
};

/// Newton's method on the squared distance, kept within the face. Faces with 3, 4, 6 and 8 nodes; nothing for others
/// and for faces without area.
std::optional<Projection> project(const Mesh& mesh, const Face& face, const Eigen::Vector3d& place);

}  // namespace kalfem::abaqus
