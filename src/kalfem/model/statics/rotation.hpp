#pragma once

#include <Eigen/Dense>

#include "kalfem/model/finite_element_model.hpp"
#include "kalfem/model/linear_model.hpp"

namespace kalfem {

/// A field of acceleration that is linear in space, a(x) = constant + gradient x; a mass m at x has the force m a(x).
struct AccelerationField {
  Eigen::Vector3d constant;  ///< [m/s^2]
  Eigen::Matrix3d gradient;  ///< [1/s^2]

  AccelerationField(const Eigen::Vector3d& everywhere = Eigen::Vector3d::Zero())  // NOLINT: gravity is a field
      : constant(everywhere), gradient(Eigen::Matrix3d::Zero()) {}

  [[nodiscard]] Eigen::Vector3d at(const Eigen::Vector3d& place) const { return constant + gradient * place; }
  AccelerationField& operator+=(const AccelerationField& other);
};

/// Steady rotation of the structure about an axis, seen from axes that turn with it.
struct Rotation {
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< n, of any length but 0
  Eigen::Vector3d about = Eigen::Vector3d::Zero();  ///< c, a point of the axis [m]
  double speed = 0.0;                               ///< W [rad/s]
};

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
