#include "kalfem/model/statics/rotation.hpp"

#include "kalfem/model/assembly/assembly.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

/// 1 - n n^T.
Eigen::Matrix3d across(const Eigen::Vector3d& axis) {
  const Eigen::Vector3d n = axis.normalized();
  return Eigen::Matrix3d::Identity() - n * n.transpose();
}

/// Mass of all nodes before supports and links, 6 to a node.
SparseMatrix mass_of_nodes(FiniteElementModel model) {
  model.fixed.clear();
  model.links.clear();
  model.weighted_links.clear();
  model.constraints.clear();
  const AssembledModel assembled = assemble(model);
  const SparseMatrix spread = assembled.expansion * evaluate(assembled.mass, assembled.parameters);
  return spread * SparseMatrix(assembled.expansion.transpose());
}

}  // namespace

AccelerationField& AccelerationField::operator+=(const AccelerationField& other) {
  constant += other.constant;
  gradient += other.gradient;
  return *this;
}

AccelerationField centrifugal_field(const Rotation& rotation) {
  AccelerationField field;
  field.gradient = rotation.speed * rotation.speed * across(rotation.axis);
  field.constant = -field.gradient * rotation.about;
  return field;
}

Eigen::VectorXd centrifugal_forces(const FiniteElementModel& model, const Rotation& rotation) {
  const AccelerationField field = centrifugal_field(rotation);
  Eigen::VectorXd acceleration = Eigen::VectorXd::Zero(6 * model.mesh.node_count());
  for (Index node = 0; node < model.mesh.node_count(); ++node)
    acceleration.segment<3>(6 * node) = model.mesh.axes_of(node).transpose() * field.at(model.mesh.nodes.col(node));
  return mass_of_nodes(model) * acceleration;
}

SparseMatrix spin_softening(const FiniteElementModel& model, const Rotation& rotation) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int node = 0; node < static_cast<int>(model.mesh.node_count()); ++node) {
    const Eigen::Matrix3d block = across(model.mesh.axes_of(node).transpose() * rotation.axis);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) entries.emplace_back(6 * node + i, 6 * node + j, block(i, j));
  }
  SparseMatrix projection(6 * model.mesh.node_count(), 6 * model.mesh.node_count());
  projection.setFromTriplets(entries.begin(), entries.end());
  return -rotation.speed * rotation.speed * SparseMatrix(projection * mass_of_nodes(model) * projection);
}

}  // namespace kalfem
