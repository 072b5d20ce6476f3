// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/statics/equilibrium.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace kalfem {

Resultant& Resultant::operator+=(const Resultant& other) {
  force += other.force;
  moment += other.moment + (other.centre - centre).cross(other.force);
  return *this;
}

Resultant resultant_of(const Mesh& mesh, const std::vector<DofForce>& forces, const Eigen::Vector3d& centre) {
  Resultant sum{.centre = centre};
  for (const auto& [dof, value] : forces) {
    const RigidRow row = value * rigid_row(dof.direction, mesh.nodes.col(dof.node) - centre, mesh.axes_of(dof.node));
    sum.force += row.head<3>().transpose();
    sum.moment += row.tail<3>().transpose();
  }
  return sum;
}

double relative_imbalance(const Mesh& mesh, const Resultant& sum, const std::vector<DofForce>& forces) {
  const double size = std::max(box_frame(mesh).radius, 1e-300);
  double largest = 0.0;
  for (const auto& [dof, value] : forces)
    largest = std::max(largest, std::abs(value) / (dof.direction < 3 ? 1.0 : size));
  return largest > 0.0 ? std::max(sum.force.norm(), sum.moment.norm() / size) / largest : 0.0;
}

RigidFrame box_frame(const Mesh& mesh) {
  if (mesh.node_count() == 0) return {};
  const Eigen::Vector3d lowest = mesh.nodes.rowwise().minCoeff(), highest = mesh.nodes.rowwise().maxCoeff();
  const double radius = 0.5 * (highest - lowest).norm();
  return {0.5 * (lowest + highest), radius > 0.0 ? radius : 1.0};
}

}  // namespace kalfem
