#include "kalfem/model/assembly/rigid_motion.hpp"

namespace kalfem {

RigidRow displacement_row(const Eigen::Vector3d& axis, const Eigen::Vector3d& arm) {
  RigidRow row;
  row << axis.transpose(), arm.cross(axis).transpose();
  return row;
}

RigidRow rotation_row(const Eigen::Vector3d& axis) {
  RigidRow row;
  row << Eigen::RowVector3d::Zero(), axis.transpose();
  return row;
}

RigidRow rigid_row(int direction, const Eigen::Vector3d& arm, const Eigen::Matrix3d& axes) {
  const Eigen::Vector3d axis = axes.col(direction % 3);
  return direction < 3 ? displacement_row(axis, arm) : rotation_row(axis);
}

DofSum slave_motion(Eigen::Index master, int direction, const Eigen::Vector3d& arm) {
  const RigidRow row = rigid_row(direction, arm);
  DofSum terms;
  for (int d = 0; d < 6; ++d)
    if (row[d] != 0.0) terms.push_back({{master, d}, row[d]});
  return terms;
}

RigidRow rigid_motion(const PlacedDof& dof, const RigidFrame& frame) {
  if (dof.direction < 0) return RigidRow::Zero();
  RigidRow row = rigid_row(dof.direction, dof.place - frame.centre);
  row.tail<3>() /= frame.radius;
  return row;
}

Eigen::MatrixXd rigid_motions(const std::vector<PlacedDof>& dofs, const RigidFrame& frame) {
  Eigen::MatrixXd motions(static_cast<Eigen::Index>(dofs.size()), 6);
  for (std::size_t i = 0; i < dofs.size(); ++i)
    motions.row(static_cast<Eigen::Index>(i)) = rigid_motion(dofs[i], frame);
  return motions;
}

}  // namespace kalfem
