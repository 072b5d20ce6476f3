// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/model/assembly/rigid_motion.hpp"
#include "kalfem/model/finite_element_model.hpp"

namespace kalfem {

/// Sum of forces and of their moments.
struct Resultant {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();   ///< [N]
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();  ///< about `centre` [N m]
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< [m]

  Resultant& operator+=(const Resultant& other);
};

/// A force [N] or moment [N m] at a degree of freedom.
struct DofForce {
  NodalDof dof;
  double value = 0.0;
};

/// Resultant about a centre.
Resultant resultant_of(const Mesh& mesh, const std::vector<DofForce>& forces, const Eigen::Vector3d& centre);

/// How far forces are from equilibrium: the larger of the force that is left over and the moment over the model's size,
/// relative to the largest force among them. `sum`: of all, about the middle of the model.
double relative_imbalance(const Mesh& mesh, const Resultant& sum, const std::vector<DofForce>& forces);

/// Middle of the box around the nodes, and half its diagonal [m].
RigidFrame box_frame(const Mesh& mesh);

}  // namespace kalfem
