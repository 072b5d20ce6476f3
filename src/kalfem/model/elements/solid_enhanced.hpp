#pragma once

#include "kalfem/model/elements/solid_geometry.hpp"
#include "kalfem/model/mesh/properties.hpp"

namespace kalfem {

/// Stiffness of an element whose displacements' strains e = B u are joined by strains G a of its own, without
/// continuity, that are condensed [SR90]:
///     K = int B^T D B - L^T H^-1 L,  H = int G^T D G,  L = int G^T D B,  G = j0 / j T0 M(r, s, t).
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
Eigen::MatrixXd enhanced_stiffness(CellShape shape, const SolidNodes& nodes, const Matrix6& elasticity);

/// Stiffness of a hexahedron8 of the mean strains [FB81] and of its twelve hourglass motions,
///     K = V B^T D B + Gamma^T K_h Gamma,  gamma_a = 1/8 (h_a - sum_i (h_a . x_i) b_i),
/// b_i the mean gradients of the shape functions. K_h is the stiffness of the hourglass functions st, rt, rs and rst
/// with the enhanced strains of enhanced_stiffness(), on the parallelepiped with the tangents of the centre (in the
/// manner of [Pus00]): no parameter, no locking, and equal to enhanced_stiffness() on a parallelepiped.
Eigen::MatrixXd one_point_hexahedron_stiffness(const SolidNodes& nodes, const Matrix6& elasticity);

}  // namespace kalfem
