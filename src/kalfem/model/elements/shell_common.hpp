#pragma once

#include "kalfem/model/elements/element.hpp"

namespace kalfem {

/// Share of the transverse shear area that a section in bending uses [Rei45].
inline constexpr double shear_correction = 5.0 / 6.0;

/// Modulus of shear per unit Young's modulus, 1 / (2 (1 + nu)).
double relative_shear_modulus(double poissons_ratio);

/// Plane stress per unit Young's modulus, for the strains [xx, yy, 2 xy]:
///     D = 1 / (1 - nu^2) [1, nu, 0; nu, 1, 0; 0, 0, (1 - nu) / 2].
Eigen::Matrix3d plane_stress(double poissons_ratio);

/// Throws ElementShapeError where a coordinate is not finite or two of the corners coincide.
void require_distinct(const Eigen::Matrix3Xd& corners);

/// Mass of a plate that moves by u = sum_i N_i u_i and turns by theta = sum_i N_i theta_i,
///     rho t int N_i N_j dA  in translation,  rho t^3 / 12 int N_i N_j dA  in rotation,
/// where `shares` is int N_i N_j dA [m^2], nodes x nodes. The inertia of a turn about the normal, which a plate does
/// not have, is taken like that of the others, so that the mass is positive definite and the same in all axes. Lumped:
/// sums of the rows in place of the rows.
std::vector<ElementTerm> plate_mass(const Eigen::MatrixXd& shares, MassKind mass_kind);

}  // namespace kalfem
