// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/model/mesh/properties.hpp"

namespace kalfem {

/// The finest parts into which the stiffness of a region divides so that it stays a sum of factors times matrices:
/// axial, bending_y, bending_z and torsion. Bending is one part where a product of inertia couples its planes, and the
/// whole stiffness is one where motions of an end are released, since their condensation mixes the parts.
std::vector<BeamPart> parts_of(const BeamProperty& property);

/// Straight two-node beam in global axes, degrees of freedom [x y z rx ry rz] a node. Its line, the line of shear
/// centres, runs from the first column of `ends` [m] plus the first offset to the second plus the second; rigid arms
/// carry the motion of the nodes to it.
///
/// Stiffness: exact for end loads. With the deflections d = [v, w] and slopes b = [theta_z, -theta_y] of the line, both
/// planes of bending together,
///     D = E [I_z, I_yz; I_yz, I_y],   S = diag(1 / (k_y G A), 1 / (k_z G A)),   G_b = (D^-1 + 12 S / L^2)^-1,
///     K = [12 G_b/L^3, 6 G_b/L^2, -12 G_b/L^3, 6 G_b/L^2; ., (D + 3 G_b)/L, -6 G_b/L^2, (3 G_b - D)/L; ...],
/// which is that of [Prz68] in either plane where I_yz = 0. Shear factors hold along local y and z, whether these are
/// principal axes or not; a factor of 0 stands for a section that is rigid in shear. Axial force passes through the
/// centroid, u_c = u + z_c theta_y - y_c theta_z linear along the element; torsion (St Venant) turns the section about
/// the shear centre. All terms are proportional to E, since G = E / (2 (1 + nu)). One term for each of `parts`, which
/// are {none} or those of parts_of(); their sum is the same. A factor of bending multiplies D and S^-1 alike: the ratio
/// of shear to bending stays, hence also the shapes of the mass, which depends on no factor.
///
/// Mass, proportional to rho and without powers for the nonstructural part. Consistent: int rho A |u|^2 of the centroid
/// (of the nonstructural centre) with the exact static shapes [FK93], rho (I_y + I_z) of the twist, and the rotary
/// inertia rho I of a plane of bending only where its shear factor is not 0. Lumped: half the mass of either kind at
/// its centre at each end and half of rho (I_y + I_z) L, rotations by diagonal scaling, m L^2 / 78 each [HRZ76], with
/// half the rotary inertia rho I L where the shear factor is not 0; without bending's rotations, or any, as
/// BeamProperty::lumped_inertia says.
///
/// Released motions of the ends, in local axes, take the value at which they carry no force,
///     z_r = -K_rr^-1 K_ra z_a;   stiffness and mass by the same transformation [Guy65].
///
/// A section that is the same in all directions, as a circle, needs no `up` across the axis: where it has none, local z
/// is normal to the axis in some direction.
///
/// Throws ElementShapeError where the ends of the line coincide, `up` is parallel to it and the section is not round,
/// or the released motions let a part of the element move without force.
ElementMatrices beam(const Eigen::Matrix<double, 3, 2>& ends, const BeamProperty& property,
                     const BeamPlacement& placement, double poissons_ratio, MassKind mass_kind,
                     const std::vector<BeamPart>& parts = {BeamPart::none});

}  // namespace kalfem
