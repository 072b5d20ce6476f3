#pragma once

#include "kalfem/model/elements/element.hpp"
#include "kalfem/model/mesh/properties.hpp"

namespace kalfem {

/// Flat three-node shell between `corners` [m] (either way round), thin or moderately thick: MITC3+ in bending [LLB14],
/// the optimal triangle with drilling rotations in its plane [Fel03].
///
/// Bending: w linear, the turn of the normals linear with a cubic bubble, which is condensed; curvatures interpolated,
/// transverse shear assumed from six inner places, 5/6 of G.
/// Membrane: constant strain with sides that bulge with the drilling rotations, and strains linear in them; exact for
/// bending in the plane of two triangles that make a rectangle. Facets of a thin surface curved both ways bend against
/// each other in their planes, so that coarse meshes of such are stiff; the error falls with h^2.
///
/// The mid-surface stands `offset` off the nodes along the normal by the right-hand rule; rigid arms carry the motion.
/// Stiffness: the membrane has the term E t. The condensation mixes t and t^3, so that the term of bending and
/// transverse shear is formed at the property's thickness and proportional to E only. Mass: rho t and rho t^3 / 12, see
/// plate_mass(). Exact in constant membrane strain and curvature. Throws ElementShapeError for corners that coincide or
/// lie on a line.
ElementMatrices shell3(const Eigen::Matrix<double, 3, 3>& corners, double poissons_ratio, const ShellProperty& property,
                       MassKind mass_kind);

/// The same element with any cross-section, in axes whose x is `direction` laid into the triangle, or the first side
/// where that is zero. The share of the linear membrane strains is the general one of [Fel03], which makes the triangle
/// optimal for A in the mean over all directions. B couples the mean membrane strain with the mean curvature.
/// Stiffness and mass are one term each, without powers. Throws ElementShapeError for a direction along the normal too.
ElementMatrices shell3(const Eigen::Matrix<double, 3, 3>& corners, const LaminateProperty& property,
                       const Eigen::Vector3d& direction, MassKind mass_kind);

}  // namespace kalfem
