#pragma once

#include <vector>

#include "kalfem/model/elements/solid_rules.hpp"

namespace kalfem {

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
