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

/// Strains [xx yy zz xy yz xz], engineering shear, per motion [x y z] of each node: 6 x 3 nodes.
using StrainMatrix = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 3 * most_solid_nodes>;

/// An element at one integration point.
struct SolidPoint {
  Eigen::Vector3d place;     ///< natural
  Eigen::Matrix3d tangents;  ///< x,r  x,s  x,t in columns [m]
  ShapeSlopes gradients;     ///< N_i,x  N_i,y  N_i,z [1/m]
  double jacobian = 0.0;     ///< det(x,r x,s x,t) > 0 [m^3]
  double volume = 0.0;       ///< that the point stands for [m^3]
};

/// The element at the points of a rule. Throws ElementShapeError where a Jacobian is not positive.
std::vector<SolidPoint> solid_points(const IntegrationRule& rule, const SolidNodes& nodes);

/// The element at one natural place; the Jacobian may be of any sign, and the gradients are not set.
SolidPoint solid_tangents(const IntegrationPoint& at, const SolidNodes& nodes);

/// Strains of the displacements u = sum_i N_i u_i, by the gradients of N_i.
StrainMatrix strain_matrix(const ShapeSlopes& gradients);

/// Throws ElementShapeError for coordinates that are not finite, nodes that coincide, a shape that is flat or inside
/// out, and a linear shape that is folded at a corner. A Jacobian of zero at a corner, as that of a face with an angle
/// of 180 degrees or of sides with their middle nodes at a quarter, is no fault.
void require_sound(CellShape shape, const SolidNodes& nodes);

}  // namespace kalfem
