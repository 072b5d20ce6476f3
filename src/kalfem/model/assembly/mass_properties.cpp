#include "kalfem/model/assembly/mass_properties.hpp"

#include "kalfem/model/assembly/rigid_motion.hpp"
#include "kalfem/model/finite_element_model.hpp"

namespace kalfem {
namespace {

std::vector<Eigen::Index> nodes_of_set(const Mesh& mesh, const std::string& name) {
  const auto found = mesh.node_sets.find(name);
  return found == mesh.node_sets.end() ? std::vector<Eigen::Index>{} : found->second;
}

}  // namespace

Eigen::MatrixXd rigid_body_modes(const FiniteElementModel& model, const AssembledModel& assembled) {
  Eigen::MatrixXd modes(assembled.size(), 6);
  for (Eigen::Index i = 0; i < assembled.size(); ++i) {
    const auto& [node, direction] = assembled.dofs[static_cast<std::size_t>(i)];
    modes.row(i) = rigid_row(direction, model.mesh.nodes.col(node));
  }
  for (const auto node : nodes_of_set(model.mesh, scalar_points))
    if (const auto place = assembled.find({node, 0}); place >= 0) modes.row(place).setZero();
  return modes;
}

Eigen::Vector3d moving_mass(const FiniteElementModel& model, const AssembledModel& assembled) {
  const Eigen::MatrixXd translations = rigid_body_modes(model, assembled).leftCols<3>();
  return (translations.transpose() * (evaluate(assembled.mass, assembled.parameters) * translations)).diagonal();
}

MassProperties mass_properties(const AssembledModel& assembled) {
  Matrix6 matrix = Matrix6::Zero();
  for (const auto& part : assembled.rigid_mass)
    matrix += affine_factor(part.powers, assembled.parameters) * part.matrix;
  MassProperties properties;
  properties.mass = matrix.diagonal().head<3>().maxCoeff();
  if (!(properties.mass > 0.0)) return properties;
  // The coupling block is m [c]^T with the cross-product matrix of the centre.
  const Eigen::Matrix3d coupling = matrix.bottomLeftCorner<3, 3>() / properties.mass;
  properties.centre = 0.5 * Eigen::Vector3d(coupling(2, 1) - coupling(1, 2), coupling(0, 2) - coupling(2, 0),
                                            coupling(1, 0) - coupling(0, 1));
  const auto& c = properties.centre;
  properties.inertia = matrix.bottomRightCorner<3, 3>() -
                       properties.mass * (c.squaredNorm() * Eigen::Matrix3d::Identity() - c * c.transpose());
  return properties;
}

}  // namespace kalfem
