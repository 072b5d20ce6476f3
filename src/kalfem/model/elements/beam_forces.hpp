// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "kalfem/model/elements/beam.hpp"

namespace kalfem {

/// What one side of a beam's section exerts on the other, in local axes: the axial force N at the centroid, shear V_y
/// and V_z and torsion T at the shear centre [N, N m], and the bending moments about the axes through the centroid
///     M_y = int z sigma dA,  M_z = -int y sigma dA [N m];
/// of the part towards the second end on that towards the first: N > 0 is tension.
using SectionForces = Eigen::Matrix<double, 6, 1>;  ///< [N V_y V_z T M_y M_z]

/// Gravity or another field of acceleration that acts on the mass of a beam, linear in space; global axes.
struct BeamField {
  Eigen::Matrix<double, 3, 2> at_nodes = Eigen::Matrix<double, 3, 2>::Zero();  ///< [m/s^2]
  Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();                          ///< [1/s^2]
};

/// Forces and moments of a field at the two nodes of a beam, global axes: int N^T m a(x) ds with the shapes of the mass
/// in beam(), the field at the places of the centroids and of the nonstructural mass; of a lumped mass at those of its
/// ends. How the field differs across a section, against its rotary inertia, is left out.
/// Throws ElementShapeError as beam() does.
Eigen::Matrix<double, 12, 1> beam_field_forces(const Eigen::Matrix<double, 3, 2>& ends, const BeamProperty& property,
                                               const BeamPlacement& placement, const IsotropicMaterial& material,
                                               MassKind mass_kind, const BeamField& field);

/// Section forces at the two ends of a beam under the motions [x y z rx ry rz] of its nodes. `field`: acts on its mass.
/// `loads`: on its line, as forces at its nodes, see
/// beam_loads.hpp. The ends carry K q less the nodal forces that both give the element, so that moments are those of
/// the distributed load.
/// Throws ElementShapeError as beam() does.
std::array<SectionForces, 2> beam_forces(
    const Eigen::Matrix<double, 3, 2>& ends, const BeamProperty& property, const BeamPlacement& placement,
    const IsotropicMaterial& material, MassKind mass_kind, const Eigen::VectorXd& motions, const BeamField& field = {},
    const Eigen::Matrix<double, 12, 1>& loads = Eigen::Matrix<double, 12, 1>::Zero());

/// Stiffness that an axial force N (tension > 0) gives a beam across its line, int N (v'^2 + w'^2) dx / 2 of the
/// deflections of beam(), in the motions of the nodes. The turn of the section about the line is left out.
Eigen::MatrixXd beam_geometric_stiffness(const Eigen::Matrix<double, 3, 2>& ends, const BeamProperty& property,
                                         const BeamPlacement& placement, double poissons_ratio, double axial_force);

/// Axial stress of axial force and bending in a fibre at `place`, local y and z from the centroid [m].
double axial_stress(const SectionForces& forces, const BeamSection& section, const Eigen::Vector2d& place);

/// Smallest and largest axial stress in a section [Pa].
struct FibreStress {
  double lowest = 0.0, highest = 0.0;
};

/// Stress of axial force and bending at the outline of the section; nothing where the outline is unknown.
std::optional<FibreStress> fibre_stress(const SectionForces& forces, const BeamSection& section);

}  // namespace kalfem
