#pragma once

#include "kalfem/model/properties.hpp"

namespace kalfem {

/// Straight two-node beam between the columns of `ends` [m], in global axes, degrees of freedom [x y z rx ry rz] a
/// node.
///
/// Stiffness: exact for end loads. In each plane of bending, with Phi = 12 E I / (G k A L^2),
///     K = E I / ((1 + Phi) L^3) [12, 6L, -12, 6L; ., (4 + Phi) L^2, -6L, (2 - Phi) L^2; ., ., 12, -6L; ., ., ., (4 +
///     Phi) L^2]
/// [Prz68]; a shear factor k = 0 stands for an infinite one (Phi = 0, Euler-Bernoulli). All terms are proportional to
/// E, since G = E / (2 (1 + nu)).
///
/// Mass, proportional to rho. Consistent: int rho A N_v^T N_v + rho I N_theta^T N_theta dx with the exact static shapes
/// [FK93]; the second, rotary part only where the shear factor is not 0. Lumped: diagonal in the beam's axes, half the
/// mass and half the polar inertia rho (I_y + I_z) L at each end, rotations by diagonal scaling, m L^2 / 78 each
/// [HRZ76], with the rotary inertia rho I L / 2 where the shear factor is not 0.
///
/// The centroid line stands off both nodes by `property.offset`; a rigid arm carries the motion.
/// Throws ElementShapeError where the ends coincide or `property.up` is parallel to the axis.
ElementMatrices beam(const Eigen::Matrix<double, 3, 2>& ends, const BeamProperty& property, double poissons_ratio,
                     MassKind mass_kind);

}  // namespace kalfem
