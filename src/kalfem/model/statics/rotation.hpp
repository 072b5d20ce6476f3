#pragma once

#include "kalfem/model/linear_model.hpp"
#include "kalfem/model/statics/load_case.hpp"

namespace kalfem {

/// a(x) = W^2 (1 - n n^T) (x - c).
AccelerationField centrifugal_field(const Rotation& rotation);

/// Its forces on all nodes, 6 to a node: M a with the mass matrix before links and supports and the field at the nodes,
/// without rotations; the elements' shape functions carry it between the nodes.
Eigen::VectorXd centrifugal_forces(const FiniteElementModel& model, const Rotation& rotation);

/// How the centrifugal forces grow with the displacement, as a stiffness of all nodes (spin softening):
///     K_s = -W^2 P M P,   P = 1 - n n^T of each node's translations, 0 of its rotations.
/// Coriolis forces, which couple velocities, are no stiffness and are left out.
SparseMatrix spin_softening(const FiniteElementModel& model, const Rotation& rotation);

}  // namespace kalfem
