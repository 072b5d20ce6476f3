#pragma once

#include <vector>

#include "kalfem/model/finite_element_model.hpp"

// Small motions of a body that does not deform, q = [t; r]: the translation of a centre [m] and the rotation about it
// [rad].

namespace kalfem {

/// What one component of a point does in each of the six motions: u = row q.
using RigidRow = Eigen::Matrix<double, 1, 6>;

/// Displacement along `axis` at `arm` from the centre: axis . (t + r x arm).
RigidRow displacement_row(const Eigen::Vector3d& axis, const Eigen::Vector3d& arm);
/// Rotation about `axis`: axis . r.
RigidRow rotation_row(const Eigen::Vector3d& axis);
/// Either of them in a direction 0 .. 5 along the columns of `axes`.
RigidRow rigid_row(int direction, const Eigen::Vector3d& arm,
                   const Eigen::Matrix3d& axes = Eigen::Matrix3d::Identity());

/// The motion in a global direction of a rigid link's slave at `arm` from its master, as a sum over the master's.
DofSum slave_motion(Eigen::Index master, int direction, const Eigen::Vector3d& arm);

/// Where a degree of freedom stands.
struct PlacedDof {
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  ///< [m]
  int direction = -1;                               ///< 0 .. 5; -1: a generalised coordinate, which has no place
};

/// Axes of rigid-body motions: translations by 1 along x, y, z, and rotations about axes through `centre` by the angle
/// that moves a point at the distance `radius` by 1.
struct RigidFrame {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius = 1.0;
};

/// What a degree of freedom does in each of the six motions.
RigidRow rigid_motion(const PlacedDof& dof, const RigidFrame& frame = {});
/// The same of many, n x 6.
Eigen::MatrixXd rigid_motions(const std::vector<PlacedDof>& dofs, const RigidFrame& frame = {});

}  // namespace kalfem
