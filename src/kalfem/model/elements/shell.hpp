// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "kalfem/model/elements/element.hpp"
#include "kalfem/model/mesh/properties.hpp"

namespace kalfem {

/// Share of the transverse shear area that a section in bending uses [Rei45].
inline constexpr double shear_correction = 5.0 / 6.0;

/// Modulus of shear per unit Young's modulus, 1 / (2 (1 + nu)).
double relative_shear_modulus(double poissons_ratio);

/// Plane stress per unit Young's modulus, for the strains [xx, yy, 2 xy]:
///     D = 1 / (1 - nu^2) [1, nu, 0; nu, 1, 0; 0, 0, (1 - nu) / 2].
Eigen::Matrix3d plane_stress(double poissons_ratio);

/// Plate of one isotropic material: A = t D, S = 5/6 t G, D_b = t^3 / 12 D, all per unit Young's modulus.
ShellStiffness isotropic_section(double poissons_ratio, double thickness);

/// Throws ElementShapeError where a coordinate is not finite or two of the corners coincide.
void require_distinct(const Eigen::Matrix3Xd& corners);

/// The axis `direction` laid into the plane with the normal `normal`; `first_side` where the direction is zero. Throws
/// ElementShapeError where the direction is along the normal.
Eigen::Vector3d axis_in_surface(const Eigen::Vector3d& direction, const Eigen::Vector3d& first_side,
                                const Eigen::Vector3d& normal);

/// Masses of a plate that moves by u = sum_i N_i u_i and turns by theta = sum_i N_i theta_i: int N_i N_j dA [m^2] over
/// the displacements, and the same over the rotations. The inertia of a turn about the normal, which a plate does not
/// have, is taken like that of the others, so that the mass is positive definite and the same in all axes. Lumped:
/// sums of the rows in place of the rows.
struct PlateMass {
  Eigen::MatrixXd translation;  ///< per mass an area
  Eigen::MatrixXd rotation;     ///< per rotary inertia an area
};
/// `shares`: int N_i N_j dA, nodes x nodes.
PlateMass plate_mass(const Eigen::MatrixXd& shares, MassKind mass_kind);

/// rho t and rho t^3 / 12, and the nonstructural mass without powers.
std::vector<ElementTerm> isotropic_mass(const PlateMass& mass, double nonstructural_mass);
/// One term without powers.
std::vector<ElementTerm> section_mass(const PlateMass& mass, double amount, double rotary_inertia);

/// How a shell takes the drilling rotations of its corners, see ShellEdges.
struct DrillingOptions {
  /// Sides 1-2, 2-3, 3-1 of a triangle that do not bulge with the drilling rotations of their ends.
  std::array<bool, 3> straight = {};
  /// Corners whose drilling rotation is the turn of the surface at the centre, whatever their node's rotation is.
  std::array<bool, 4> following = {};
  friend bool operator==(const DrillingOptions&, const DrillingOptions&) = default;
};

/// Work of a unit normal force per length along a bulging side of the length l, per difference of the drilling
/// rotations of its ends: l^2 / 8, 3/2 of the cubic that these give a beam [BF85], [Fel03].
inline double bulge(double length) { return length * length / 8.0; }

/// Carries matrices from places that stand off the nodes to the nodes, by rigid arms u = u_node + theta x arm.
/// `arms`: from each node to its place [m], 3 x nodes.
void carry_to_nodes(ElementMatrices& matrices, const Eigen::Matrix3Xd& arms);

/// Shell of any cross-section, 3 x 3 or 3 x 4 corners [m]: shell3() or shell4() of a LaminateProperty. Its x axis is
/// `direction` laid into the surface, or the first side where that is zero.
ElementMatrices laminate(const Eigen::Matrix3Xd& corners, const LaminateProperty& property,
                         const Eigen::Vector3d& direction, MassKind mass_kind, const DrillingOptions& drilling = {});

/// Flat three-node shell between `corners` [m] (either way round), thin or moderately thick: MITC3+ in bending [LLB14],
/// the optimal triangle with drilling rotations in its plane [Fel03].
///
/// Bending: w linear, the turn of the normals linear with a cubic bubble, which is condensed; curvatures interpolated,
/// transverse shear assumed from six inner places, 5/6 of G.
/// Membrane: constant strain with sides that bulge with the drilling rotations, and strains linear in them; exact for
/// bending in the plane of two triangles that make a rectangle. With all sides straight and all corners following it is
/// the triangle of constant strain. Facets of a thin surface curved both ways bend against
/// each other in their planes, so that coarse meshes of such are stiff; the error falls with h^2.
///
/// The mid-surface stands `offset` off the nodes along the normal by the right-hand rule; rigid arms carry the motion.
/// Stiffness: the membrane has the term E t. The condensation mixes t and t^3, so that the term of bending and
/// transverse shear is formed at the property's thickness and proportional to E only. Mass: rho t and rho t^3 / 12, see
/// plate_mass(). Exact in constant membrane strain and curvature. Throws ElementShapeError for corners that coincide or
/// lie on a line.
ElementMatrices shell3(const Eigen::Matrix<double, 3, 3>& corners, double poissons_ratio, const ShellProperty& property,
                       MassKind mass_kind, const DrillingOptions& drilling = {});

/// The same element with any cross-section, in axes whose x is `direction` laid into the triangle, or the first side
/// where that is zero. The share of the linear membrane strains is the general one of [Fel03], which makes the triangle
/// optimal for A in the mean over all directions. B couples the mean membrane strain with the mean curvature.
/// Stiffness and mass are one term each, without powers. Throws ElementShapeError for a direction along the normal too.
ElementMatrices shell3(const Eigen::Matrix<double, 3, 3>& corners, const LaminateProperty& property,
                       const Eigen::Vector3d& direction, MassKind mass_kind, const DrillingOptions& drilling = {});

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
                       MassKind mass_kind, const DrillingOptions& drilling = {});

/// The same element with any cross-section,
///     W = 1/2 (e^T A e + 2 e^T B k + k^T D k + g^T S g),
/// in axes whose x is `direction` laid into the surface at the centre, or the first side where that is zero. In place
/// of G t and E t^3 / 12 the drilling rotations meet the means over all directions 2 / (a_11 + a_22 - 2 a_12 + a_66),
/// a = A^-1, and 8 / (3 d_11 + 3 d_22 + 2 d_12 + d_66), d = D^-1.
/// Stiffness and mass are one term each, without powers. Throws ElementShapeError for a direction along the normal too.
ElementMatrices shell4(const Eigen::Matrix<double, 3, 4>& corners, const LaminateProperty& property,
                       const Eigen::Vector3d& direction, MassKind mass_kind, const DrillingOptions& drilling = {});

}  // namespace kalfem
