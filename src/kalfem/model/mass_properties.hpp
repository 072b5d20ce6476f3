#pragma once

#include "kalfem/model/assembly.hpp"

namespace kalfem {

/// Mass, centre of gravity and inertia about it.
struct MassProperties {
  double mass = 0.0;                                  ///< [kg]
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();   ///< [m]
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about the centre, global axes [kg m^2]
};

/// From R^T M R with the rigid-body modes R: what moves with the free degrees of freedom. Mass that is lumped at or
/// carried by fixed degrees of freedom does not count, so an unsupported model gives the whole.
MassProperties mass_properties(const FiniteElementModel& model, const AssembledModel& assembled);

/// Rigid-body motion of the free degrees of freedom about the origin: translations along x, y, z [m/m], rotations about
/// x, y, z [m/rad, rad/rad]; n x 6.
Eigen::MatrixXd rigid_body_modes(const FiniteElementModel& model, const AssembledModel& assembled);

}  // namespace kalfem
