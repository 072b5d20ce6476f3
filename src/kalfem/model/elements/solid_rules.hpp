#pragma once

#include <Eigen/Dense>
#include <vector>

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

/// A point of an integration rule in natural coordinates, with the shape functions there.
struct IntegrationPoint {
  Eigen::Vector3d place;
  double weight = 0.0;
  ShapeFunctions functions;
};

using IntegrationRule = std::vector<IntegrationPoint>;

/// What a rule is for.
enum class RulePurpose {
  strain,          ///< stiffness: enough points that nothing but a rigid motion is free of strain
  reduced_strain,  ///< stiffness with fewer points
  mass,            ///< exact for the mass of straight-sided elements
  corners          ///< the corners, without weight: to look at the shape there
};

/// Rules by shape. Points along r, s and t of a hexahedron, in the triangle and along t of a wedge:
///
///     shape          strain        reduced_strain   mass
///     tetrahedron4   1             1                4
///     tetrahedron10  4             4                15
///     wedge6         3 x 2         1 x 2            7 x 3
///     wedge15        3 x 3         3 x 2            7 x 4
///     hexahedron8    2 x 2 x 2     1                3 x 3 x 3
///     hexahedron20   3 x 3 x 3     2 x 2 x 2        4 x 4 x 4
///
/// Gauss points along lines; triangles and tetrahedra of degree 1, 2 and 5 [Str71]. Computed once.
const IntegrationRule& integration_rule(CellShape shape, RulePurpose purpose);

}  // namespace kalfem
