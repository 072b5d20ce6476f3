#include "kalfem/model/assembly/rigid_mass.hpp"

#include "kalfem/model/assembly/rigid_motion.hpp"
#include "kalfem/model/scalar_points.hpp"

namespace kalfem {

using Eigen::Index;
using RigidRows = Eigen::Matrix<double, Eigen::Dynamic, 6>;

RigidMassSum::RigidMassSum(const Mesh& mesh)
    : mesh_(mesh), is_scalar_(static_cast<std::size_t>(mesh.node_count()), false) {
  if (const auto set = mesh.node_sets.find(scalar_points); set != mesh.node_sets.end())
    for (const auto node : set->second) is_scalar_[static_cast<std::size_t>(node)] = true;
}

Matrix6 RigidMassSum::of(std::span<const Index> nodes, int motions, const Eigen::MatrixXd& mass) const {
  RigidRows rows(mass.rows(), 6);
  Index row = 0;
  for (const auto node : nodes)
    for (int direction = 0; direction < motions; ++direction)
      rows.row(row++) = rigid_row(direction, mesh_.nodes.col(node));
  return rows.transpose() * mass * rows;
}

Matrix6 RigidMassSum::of(const std::vector<NodalDof>& dofs, const Eigen::SparseMatrix<double>& mass) const {
  RigidRows rows = RigidRows::Zero(mass.rows(), 6);
  for (std::size_t i = 0; i < dofs.size(); ++i)
    if (!is_scalar_[static_cast<std::size_t>(dofs[i].node)])
      rows.row(static_cast<Index>(i)) = rigid_row(dofs[i].direction, mesh_.nodes.col(dofs[i].node));
  return rows.transpose() * (mass * rows);
}

std::vector<RigidMass> RigidMassSum::list() const {
  std::vector<RigidMass> parts;
  for (const auto& [powers, matrix] : sums_) parts.push_back({powers, matrix});
  return parts;
}

}  // namespace kalfem
