#pragma once

#include "kalfem/model/assembly/assembly.hpp"

namespace kalfem {

/// Mass, centre of gravity and inertia about it.
struct MassProperties {
  double mass = 0.0;                                  ///< [kg]
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();   ///< [m]
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about the centre, global axes [kg m^2]
};

/// Of the whole structure, also of what is held: from R^T M R with the rigid-body motions R of every node. Where not
/// the same mass moves along x, y and z, as in matrices of one direction alone, the largest of the three counts.
MassProperties mass_properties(const AssembledModel& assembled);

/// Mass that the free degrees of freedom move along x, y and z [kg]: less than the whole where mass is lumped at or
/// carried by held degrees of freedom.
Eigen::Vector3d moving_mass(const FiniteElementModel& model, const AssembledModel& assembled);

/// Rigid-body motion of the free degrees of freedom about the origin: translations along x, y, z [m/m], rotations about
/// x, y, z [m/rad, rad/rad]; n x 6.
Eigen::MatrixXd rigid_body_modes(const FiniteElementModel& model, const AssembledModel& assembled);

}  // namespace kalfem
