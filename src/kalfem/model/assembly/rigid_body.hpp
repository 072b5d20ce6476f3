// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "kalfem/linalg/stiffness_factor.hpp"
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
/// The same; of a model of scalar points alone, which have no place and no direction, the sum of their mass matrix M.
MassProperties mass_properties(const FiniteElementModel& model, const AssembledModel& assembled,
                               const SparseMatrix& mass);

/// Whether all nodes of the model are scalar points.
bool has_only_scalar_points(const FiniteElementModel& model);

/// Mass that the free degrees of freedom move along x, y and z [kg]: less than the whole where mass is lumped at or
/// carried by held degrees of freedom. Of scalar points alone their mass in each of the three.
Eigen::Vector3d moving_mass(const FiniteElementModel& model, const AssembledModel& assembled, const SparseMatrix& mass);

/// Rigid-body motion of the free degrees of freedom: translations along x, y, z [m/m], rotations about x, y, z through
/// `centre` [m/rad, rad/rad]; n x 6.
Eigen::MatrixXd rigid_body_modes(const FiniteElementModel& model, const AssembledModel& assembled,
                                 const Eigen::Vector3d& centre = Eigen::Vector3d::Zero());

/// Motions without strain other than the rigid-body motions of the whole: hinges, rotations that nothing holds, parts
/// that hang on nothing. One degree of freedom for each, named "n17.rx": holding all of them leaves no mechanism.
///
/// With D the diagonal of K, the null space of the scaled stiffness D^-1/2 K D^-1/2 is found by subspace iteration with
/// (K + 1e-12 D)^-1, which needs no mass: a motion counts as one without strain where its Rayleigh quotient
/// phi^T K phi / phi^T D phi is below 3e-14, a hundred times the rounding of K; the softest mode of a cantilever of N
/// elements lies at 0.5 / N^4. The rigid-body motions that strain nothing are taken out of it; columns of
/// what is left are chosen by a pivoted QR factorisation. Degrees of freedom without any stiffness are named at once.
/// At most about 250 are found beside those. `each_part`: rigid-body motions are those of each of connected_parts(),
/// where something outside the model joins these. Throws InvalidInput where the stiffness is indefinite.
std::vector<std::string> find_mechanisms(const FiniteElementModel& model, const AssembledModel& assembled,
                                         const SparseMatrix& stiffness, bool each_part = false);
std::vector<std::string> find_mechanisms(const FiniteElementModel& model, const AssembledModel& assembled);

/// The factor of K, held against the rigid-body motions of the whole that strain nothing. Where there is one, the model
/// is no mechanism; where there is none, find_mechanisms() tells.
std::optional<StiffnessFactor> factor_held(const FiniteElementModel& model, const AssembledModel& assembled,
                                           const SparseMatrix& stiffness, const SparseMatrix& mass,
                                           bool each_part = false);

}  // namespace kalfem
