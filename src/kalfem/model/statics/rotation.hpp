// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/model/linear_model.hpp"
#include "kalfem/model/statics/load_case.hpp"

namespace kalfem {

/// a(x) = W^2 (1 - n n^T) (x - c).
AccelerationField centrifugal_field(const Rotation& rotation);

/// Forces of a field on all nodes, 6 to a node, before links and supports: int N^T rho a(x) dV, each mass in the field
/// at its own place, so that resultant and moment are those of the masses.
/// * Solids and shells: M a of the field at the nodes, at the mid-surface of shells that stand off them.
/// * Beams: see beam_field_forces().
/// * Point masses: m a at their centre, and int rho r x (G r) dV of their inertia with the gradient G.
/// * Matrices of another code: M a of the field at the nodes, without rotations.
Eigen::VectorXd field_forces(const FiniteElementModel& model, const AccelerationField& field);

/// Those of centrifugal_field().
Eigen::VectorXd centrifugal_forces(const FiniteElementModel& model, const Rotation& rotation);

/// How the centrifugal forces grow with the displacement, as a stiffness of all nodes (spin softening):
///     K_s = -W^2 P M P,   P = 1 - n n^T of each node's translations, 0 of its rotations.
/// Coriolis forces, which couple velocities, are no stiffness and are left out.
SparseMatrix spin_softening(const FiniteElementModel& model, const Rotation& rotation);

}  // namespace kalfem
