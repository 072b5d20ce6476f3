// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "kalfem/model/mesh/properties.hpp"

namespace kalfem {

/// Plane stress and transverse shear of a material with three planes of symmetry, in its axes 1 and 2.
struct OrthotropicSheet {
  double youngs_modulus_1 = 0.0;   ///< E1 [Pa]
  double youngs_modulus_2 = 0.0;   ///< E2 [Pa]
  double poissons_ratio_12 = 0.0;  ///< nu12: contraction along 2 per stretch along 1 by a stress along 1
  double shear_modulus_12 = 0.0;   ///< G12 [Pa]
  double shear_modulus_13 = 0.0;   ///< G13 [Pa]; 0: as G12
  double shear_modulus_23 = 0.0;   ///< G23 [Pa]; 0: as G12
  double density = 0.0;            ///< rho [kg/m^3]
};

/// An isotropic material as a sheet.
OrthotropicSheet sheet_of(const IsotropicMaterial& material);

/// One layer of a laminate.
struct Ply {
  OrthotropicSheet material;
  double thickness = 0.0;  ///< [m]
  double angle = 0.0;      ///< from the laminate's x axis to the ply's axis 1, positive from x to y [rad]
};

/// How the transverse shear stiffness S of a laminate follows from its plies.
enum class TransverseShear {
  equilibrium,  ///< by the energy of the shear stresses that balance bending along x and y [Roh88]: 5/6 G t of one
                ///< layer, about that of the core alone in a sandwich
  five_sixths   ///< 5/6 of the sum of G t over the plies
};

/// Cross-section of plies, from the bottom up, by classical lamination theory with first-order shear [Red04]:
///     A, B, D = sum_k int [1, z, z^2] Q_k dz,   mass = sum_k int rho_k dz,   rotary inertia = sum_k int rho_k z^2 dz,
/// with Q_k the plane stress of ply k turned by its angle. z is measured from the height of the centre of mass, which
/// is the middle of plies of one density; that height is the offset of the section.
/// `bottom`: height of the underside above the nodes along the normal [m]; -t/2 centres the stack at the nodes.
/// Throws InvalidInput for no plies, and for thicknesses, moduli and densities that are not physical, all together.
LaminateProperty laminated(const std::vector<Ply>& plies, double bottom,
                           TransverseShear transverse_shear = TransverseShear::equilibrium);

/// A plate whose resistances are given apart from each other, as Nastran's PSHELL does.
struct SeparatePlate {
  std::optional<OrthotropicSheet> membrane;  ///< of A and of the mass; none: a millionth of the bending's
  std::optional<OrthotropicSheet> bending;   ///< of D; none: a millionth of the membrane's
  std::optional<OrthotropicSheet> shear;     ///< of S; none: a thousand times that of the others
  double thickness = 0.0;                    ///< t [m]
  double bending_ratio = 1.0;                ///< 12 I / t^3
  double shear_ratio = 5.0 / 6.0;            ///< t_s / t
  double nonstructural_mass = 0.0;           ///< [kg/m^2]
  double offset = 0.0;                       ///< mid-surface above the nodes [m]
  double angle = 0.0;                        ///< from the section's x axis to axis 1 of the sheets [rad]
};

/// A = t Q_membrane, D = bending_ratio t^3/12 Q_bending, S = shear_ratio t G_shear, B = 0; mass = rho t beside the
/// nonstructural one, rotary inertia mass t^2/12. What is not there is made small, or large, enough to be of no
/// account, since each motion needs a stiffness.
/// Throws InvalidInput where neither membrane nor bending is given, and for values that are not physical.
LaminateProperty plate_section(const SeparatePlate& plate);

}  // namespace kalfem
