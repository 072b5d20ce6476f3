// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/model/elements/solid.hpp"

namespace kalfem {

/// Largest number of enhanced strain modes of an element.
inline constexpr int most_modes = 12;
using ModeMatrix = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, most_modes>;  ///< strains, one mode a column

/// Strains of an element at one integration point.
struct EnhancedPoint {
  StrainMatrix strains;  ///< B, of the displacements
  ModeMatrix modes;      ///< G
  double volume = 0.0;
};

/// An element whose displacements' strains e = B u are joined by strains G a of its own, without continuity, that are
/// condensed [SR90]:
///     K = int B^T D B - L^T H^-1 L,  a = -H^-1 L u,  H = int G^T D G,  L = int G^T D B,  G = j0 / j T0 M(r, s, t).
/// M holds strains in the natural axes with no mean over the element, T0 turns those of the element's centre into
/// global ones, j is the Jacobian (j0 of the centre): G has no mean, so that constant strain is exact for any shape.
///
/// hexahedron8, 12 of them: those of Simo and Rifai,
///     rr: r,  ss: s,  tt: t,  2rs: r, s,  2st: s, t,  2rt: r, t,
/// which make bending free of shear, and the volume changes rs, st, rt [SAT93], without which an incompressible
/// material locks.
///
/// wedge6, 12, with r and s from the centre of the triangle:
///     rr, ss and 2rs: r, s,  tt: t,  2rt and 2st: t,  [2rt 2st]: [r 0], [0 s], [s r],
/// those of the quadratic displacements that a wedge lacks. Bending about the axes of the triangle is free of shear;
/// bending in the plane of the triangle stays that of constant strain, as it must.
std::vector<EnhancedPoint> enhanced_points(CellShape shape, const SolidNodes& nodes);

/// G at a place where the Jacobian is j, of an element with these tangents at its centre.
ModeMatrix enhanced_strains(CellShape shape, const Eigen::Vector3d& place, const Eigen::Matrix3d& centre, double j);

/// Tangents at the centre of gravity of the natural shape.
Eigen::Matrix3d centre_tangents(CellShape shape, const SolidNodes& nodes);

/// What is left of an element when its own strains carry no force.
struct Condensation {
  Eigen::MatrixXd stiffness;  ///< K
  Eigen::MatrixXd amounts;    ///< -H^-1 L: of each mode per motion of the nodes
};
Condensation condense(const std::vector<EnhancedPoint>& points, const Matrix6& elasticity);

}  // namespace kalfem
