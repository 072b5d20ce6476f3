#pragma once

#include <Eigen/Dense>

#include "kalfem/model/mesh/mesh.hpp"

namespace kalfem {

/// Largest number of nodes of a solid.
inline constexpr int most_solid_nodes = 20;

using SolidNodes = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, most_solid_nodes>;   ///< places, 3 x nodes
using ShapeVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, most_solid_nodes, 1>;  ///< one value a node
using ShapeSlopes = Eigen::Matrix<double, Eigen::Dynamic, 3, 0, most_solid_nodes, 3>;  ///< one gradient a node

/// Shape functions of a solid at one natural place (r, s, t), and their slopes along r, s and t.
struct ShapeFunctions {
  ShapeVector values;  ///< N_i
  ShapeSlopes slopes;  ///< N_i,r  N_i,s  N_i,t
};

/// Shape functions of the tetrahedra (0 <= r, s, t, r + s + t <= 1), the wedges (a triangle 0 <= r, s, r + s <= 1 along
/// -1 <= t <= 1) and the hexahedra (-1 <= r, s, t <= 1): linear, or quadratic of serendipity type [ZTZ05]. The shape
/// must be a solid.
ShapeFunctions solid_shape_functions(CellShape shape, const Eigen::Vector3d& place);

/// Natural places of the nodes, 3 x nodes, in the order of CellShape.
SolidNodes natural_nodes(CellShape shape);

}  // namespace kalfem
