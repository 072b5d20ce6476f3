// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/locally_nonlinear_system.hpp"

namespace kalfem {

Eigen::MatrixXd LocallyNonlinearSystem::full_damping() const {
  return Eigen::MatrixXd(damping) + damping_force(modal_damping, mass, Eigen::MatrixXd::Identity(size(), size()));
}

Eigen::Index LocallyNonlinearSystem::connector_states() const {
  Eigen::Index count = 0;
  for (const auto& connector : connectors) count += static_cast<Eigen::Index>(connector.law->states().size());
  return count;
}

Eigen::MatrixXd LocallyNonlinearSystem::connector_directions() const {
  Eigen::MatrixXd directions(size(), connector_count());
  for (Eigen::Index j = 0; j < connector_count(); ++j)
    directions.col(j) = connectors[static_cast<std::size_t>(j)].deformation;
  return directions;
}

Eigen::MatrixXd LocallyNonlinearSystem::connector_bases() const {
  Eigen::MatrixXd bases(connector_count(), input_count());
  for (Eigen::Index j = 0; j < connector_count(); ++j)
    bases.row(j) = connectors[static_cast<std::size_t>(j)].base.transpose();
  return bases;
}

}  // namespace kalfem
