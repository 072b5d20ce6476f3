// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "kalfem/model/elements/element.hpp"
#include "kalfem/model/mesh/mesh.hpp"
#include "kalfem/model/mesh/properties.hpp"

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

/// Throws ElementShapeError for coordinates that are not finite, nodes that coincide and a shape that is inside out. A
/// Jacobian of zero or less at some corners, as that of a face with an angle of 180 degrees or more, or of sides with
/// their middle nodes at a quarter, is no fault where that at the integration points is positive, see solid_points().
void require_sound(CellShape shape, const SolidNodes& nodes);

/// Isotropic elasticity per unit Young's modulus,
///     D = lambda 1 1^T + 2 mu I,  2 mu = 1 / (1 + nu),  lambda = 2 mu nu / (1 - 2 nu).
Matrix6 isotropic_elasticity(double poissons_ratio);

/// Solid element of any shape through `nodes` [m], 3 x nodes, with the motions [x y z] of each node:
///     K = int B^T D B dV,   M = rho int N^T N dV,   D isotropic of E = 1 and nu, or the property's elasticity.
///
/// What the kinds are for each shape (points of the stiffness in brackets, see integration_rule()):
///
///     shape          standard                  full         mean_dilatation  reduced
///     tetrahedron4   (1)                       as standard  as standard      as standard
///     tetrahedron10  (4)                       as standard  as standard      as standard
///     wedge6         enhanced strains (3 x 2)  (3 x 2)      B-bar (3 x 2)    (1 x 2); 1 motion without stiffness
///     wedge15        (3 x 3)                   (3 x 3)      as full          (3 x 2); 3 motions without stiffness
///     hexahedron8    enhanced strains (2^3)    (2^3)        B-bar (2^3)      mean strains, hourglass stabilised
///     hexahedron20   (2^3), stabilised         (3^3)        as full          (2^3); 6 motions without stiffness
///
/// Motions without stiffness are those of a single free element beside the six rigid ones; a mesh more than one element
/// wide holds most of them, one row of elements does not. All kinds are exact in constant strain, on distorted elements
/// too. tetrahedron4 is stiff in bending and locks where nu comes near 1/2, wedge6 in its triangle likewise: the
/// quadratic shapes are meant for those. enhanced_points(), one_point_hexahedron_stiffness() and
/// stabilised_stiffness() say what stands behind the others.
///
/// The order of the nodes is that of Abaqus and CalculiX for all six shapes. Their types, by comparison with CalculiX
/// 2.20 (displacements of distorted blocks under load are equal to 1e-6 where no difference is named):
///
///     C3D4, C3D10  any kind
///     C3D6         reduced
///     C3D8         full in CalculiX, which has no B-bar there; mean_dilatation is what Abaqus documents
///     C3D8I        standard, equal to 1 % in statics: CalculiX leaves out the three volume changes and the factor
///                  j0 / j of the enhanced strains, and fails the patch test; it also gives its inner motions mass
///     C3D8R        reduced, with the same mean strains, but CalculiX's hourglass stiffness is much softer
///     C3D15, C3D20 full
///     C3D20R       reduced
///
/// CalculiX integrates the mass with the points of the stiffness, here it is exact for straight sides: frequencies of
/// coarse meshes differ by that (C3D8 and C3D20 by nothing that matters).
///
/// Stiffness: one term E, or, where the property gives the elasticity, one without powers. Mass: one term rho; lumped:
/// its diagonal, scaled to the element's mass [HRZ76].
/// Throws ElementShapeError for a shape that is no solid, a wrong number of nodes, coordinates that are not finite,
/// nodes that coincide and a geometry that is flat, folded or inside out; InvalidInput for an elasticity that is not
/// symmetric and positive definite.
ElementMatrices solid(CellShape shape, const Eigen::Matrix3Xd& nodes, const SolidProperty& property,
                      double poissons_ratio, MassKind mass_kind);

}  // namespace kalfem
