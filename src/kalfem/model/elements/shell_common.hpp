#pragma once

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

/// Carries matrices from places that stand off the nodes to the nodes, by rigid arms u = u_node + theta x arm.
/// `arms`: from each node to its place [m], 3 x nodes.
void carry_to_nodes(ElementMatrices& matrices, const Eigen::Matrix3Xd& arms);

/// Shell of any cross-section, 3 x 3 or 3 x 4 corners [m]: shell3() or shell4() of a LaminateProperty. Its x axis is
/// `direction` laid into the surface, or the first side where that is zero.
ElementMatrices laminate(const Eigen::Matrix3Xd& corners, const LaminateProperty& property,
                         const Eigen::Vector3d& direction, MassKind mass_kind);

}  // namespace kalfem
