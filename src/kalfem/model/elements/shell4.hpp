#pragma once

#include "kalfem/model/elements/element.hpp"
#include "kalfem/model/mesh/properties.hpp"

namespace kalfem {

/// Four-node shell on the bilinear surface through `corners` [m] (in turn, either way round), for thin and moderately
/// thick, flat, curved and warped parts: MITC4+ [KLB17] with enhanced membrane strains and drilling rotations.
///
/// Kinematics: x + z d, u + z sum N_i theta_i x n_i, with n_i the normals of the element's own surface at its corners
/// and d = sum N_i n_i; neighbours may meet at any angle. Strains in the surface are e + z k. Assumed are
/// * the transverse shear, linear between the middles of the sides, 5/6 of G [DB84];
/// * the membrane strain e, from the strains of the four sides and the shear at the centre, without the membrane strain
///   that a warped surface shows in bending [KLB17]; it is the interpolated one on flat elements;
/// * four strain modes of the element's own, condensed, which relieve bending in the plane [SR90].
/// k is the interpolated one. With plane stress D, per area,
///     W = E t / 2 (e^T D e + 5/6 G/E g^T g) + E t^3 / 24 k^T D k.
///
/// Drilling: G t / 20 (theta . n - turn of the surface)^2 at the centre [HB89], where rotations that change sign across
/// an element, as those of facets of a curved surface do, cost nothing; and E t^3 / 1200 |grad theta . n|^2.
///
/// The mid-surface stands `offset` off the nodes along the normals of the surface through them; rigid arms carry the
/// motion. Stiffness: terms E t and E t^3, whatever the thickness is. Mass: rho t and rho t^3 / 12, see plate_mass().
/// Exact in constant membrane strain and curvature on flat elements of any shape, and for bending in the plane of a
/// rectangle. Throws ElementShapeError for corners that coincide, an area of zero, a concave or crossed shape, and a
/// warp of more than a right angle between the normals of two corners.
ElementMatrices shell4(const Eigen::Matrix<double, 3, 4>& corners, double poissons_ratio, const ShellProperty& property,
                       MassKind mass_kind);

/// The same element with any cross-section,
///     W = 1/2 (e^T A e + 2 e^T B k + k^T D k + g^T S g),
/// in axes whose x is `direction` laid into the surface at the centre, or the first side where that is zero. In place
/// of G t and E t^3 / 12 the drilling rotations meet the means over all directions 2 / (a_11 + a_22 - 2 a_12 + a_66),
/// a = A^-1, and 8 / (3 d_11 + 3 d_22 + 2 d_12 + d_66), d = D^-1.
/// Stiffness and mass are one term each, without powers. Throws ElementShapeError for a direction along the normal too.
ElementMatrices shell4(const Eigen::Matrix<double, 3, 4>& corners, const LaminateProperty& property,
                       const Eigen::Vector3d& direction, MassKind mass_kind);

}  // namespace kalfem
