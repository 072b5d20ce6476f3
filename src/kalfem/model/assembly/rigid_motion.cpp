// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/assembly/rigid_motion.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "kalfem/model/finite_element_model.hpp"

namespace kalfem {

// A small rigid motion of translation t and rotation theta moves a point at the arm r by u = t + theta x r. Along an
// axis a this is a . u = [a^T, (r x a)^T] [t; theta], since a . (theta x r) = theta . (r x a).
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
  RigidRow row = rigid_row(dof.direction, dof.place - frame.centre, dof.axes);
  row.tail<3>() /= frame.radius;
  return row;
}

Eigen::MatrixXd rigid_motions(const std::vector<PlacedDof>& dofs, const RigidFrame& frame) {
  Eigen::MatrixXd motions(static_cast<Eigen::Index>(dofs.size()), 6);
  for (std::size_t i = 0; i < dofs.size(); ++i)
    motions.row(static_cast<Eigen::Index>(i)) = rigid_motion(dofs[i], frame);
  return motions;
}

using Eigen::Index;
using RigidRows = Eigen::Matrix<double, Eigen::Dynamic, 6>;

RigidMassSum::RigidMassSum(const Mesh& mesh)
    : mesh_(mesh), is_scalar_(static_cast<std::size_t>(mesh.node_count()), false) {
  if (const auto set = mesh.node_sets.find(scalar_points); set != mesh.node_sets.end())
    for (const auto node : set->second) is_scalar_[static_cast<std::size_t>(node)] = true;
}

// R^T m R per element: the mass of the whole moves rigidly, held nodes included, which the assembled matrix has lost.
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
      rows.row(static_cast<Index>(i)) =
          rigid_row(dofs[i].direction, mesh_.nodes.col(dofs[i].node), mesh_.axes_of(dofs[i].node));
  return rows.transpose() * (mass * rows);
}

std::vector<RigidMass> RigidMassSum::list() const {
  std::vector<RigidMass> parts;
  for (const auto& [powers, matrix] : sums_) parts.push_back({powers, matrix});
  return parts;
}

namespace {

double mean_distance(const Mesh& mesh, const WeightedLink& link) {
  double sum = 0.0;
  for (const auto& share : link.shares) sum += (mesh.nodes.col(share.node) - mesh.nodes.col(link.follower)).norm();
  return sum > 0.0 ? sum / static_cast<double>(link.shares.size()) : 1.0;
}

/// Rotations counted by what they move at this distance: all six motions are in one unit.
RigidRow in_one_unit(RigidRow row, double length) {
  row.tail<3>() /= length;
  return row;
}

}  // namespace

// Weighted least squares over the components that are followed:
//   1. rows R of rigid motion about the follower, rotations divided by the mean distance so that all are lengths;
//   2. the normal matrix R^T W R and its pseudo-inverse with a threshold: nodes on a line leave a rotation out;
//   3. fit = (R^T W R)^+ R^T W gives the motion, (R^T W R)^+ R^T W R which of the six it determines.
MeanMotion::MeanMotion(const Mesh& mesh, const WeightedLink& link, const Axes& axes)
    : length_(mean_distance(mesh, link)) {
  std::vector<RigidRow> rows;
  std::vector<double> weights;
  for (const auto& share : link.shares) {
    const Eigen::Vector3d arm = mesh.nodes.col(share.node) - mesh.nodes.col(link.follower);
    const Eigen::Matrix3d own = axes ? axes(share.node) : Eigen::Matrix3d::Identity();
    for (int d = 0; d < 6; ++d) {
      if (!share.directions[static_cast<std::size_t>(d)]) continue;
      components_.push_back({share.node, d});
      rows.push_back(in_one_unit(rigid_row(d, arm, own), length_));
      weights.push_back(share.weight * (d < 3 ? 1.0 : length_ * length_));
    }
  }
  const auto count = static_cast<Eigen::Index>(rows.size());
  Eigen::Matrix<double, 6, Eigen::Dynamic> weighted(6, count);
  Matrix6 normal = Matrix6::Zero();
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto& row = rows[static_cast<std::size_t>(i)];
    weighted.col(i) = weights[static_cast<std::size_t>(i)] * row.transpose();
    normal += weighted.col(i) * row;
  }
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver(6, 6);
  solver.setThreshold(1e-9);
  solver.compute(normal);
  resolution_ = solver.solve(Eigen::MatrixXd(normal));
  fit_ = solver.solve(Eigen::MatrixXd(weighted));
  fit_.bottomRows<3>() /= length_;
}

bool MeanMotion::determines(const RigidRow& row) const {
  const RigidRow wanted = in_one_unit(row, length_);
  return (wanted * resolution_ - wanted).cwiseAbs().maxCoeff() < 1e-6 * wanted.norm();
}

DofSum MeanMotion::follower_motion(int direction) const {
  const Eigen::RowVectorXd row = shares(rigid_row(direction, Eigen::Vector3d::Zero()));
  const double rounding = 1e-14 * std::max(1.0, 1.0 / length_);
  DofSum terms;
  for (Eigen::Index i = 0; i < row.size(); ++i)
    if (std::abs(row[i]) > rounding) terms.push_back({components_[static_cast<std::size_t>(i)], row[i]});
  return terms;
}

// The mass sits at the offset o and moves by u + theta x o. With T = [I, -[o x]; 0, I] the matrix is T^T diag(m I, J)
// T, whose rotational block is the parallel-axis theorem J - m [o x]^2.
Eigen::Matrix<double, 6, 6> point_mass(const PointMass& mass) {
  const auto& o = mass.offset;
  Eigen::Matrix3d cross;
  cross << 0.0, -o.z(), o.y(), o.z(), 0.0, -o.x(), -o.y(), o.x(), 0.0;
  Eigen::Matrix<double, 6, 6> matrix;
  matrix.topLeftCorner<3, 3>() = mass.mass * Eigen::Matrix3d::Identity();
  matrix.topRightCorner<3, 3>() = -mass.mass * cross;
  matrix.bottomLeftCorner<3, 3>() = mass.mass * cross;
  matrix.bottomRightCorner<3, 3>() = mass.inertia - mass.mass * cross * cross;
  return matrix;
}

Eigen::Matrix<double, 6, 6> unit_mass_at(const Eigen::Vector3d& offset) {
  return point_mass({.mass = 1.0, .offset = offset});
}

// M(o) is of second order in o, so its values at o = 0, e_a, -e_a and e_a + e_b tell it exactly.
std::vector<std::pair<std::map<std::string, int>, Eigen::MatrixXd>> unit_mass_by_offset(const std::string& name) {
  const std::array axes{".offset_x", ".offset_y", ".offset_z"};
  const auto unit = [](int axis) { return Eigen::Vector3d(Eigen::Vector3d::Unit(axis)); };
  const auto at_node = unit_mass_at(Eigen::Vector3d::Zero());
  std::vector<std::pair<std::map<std::string, int>, Eigen::MatrixXd>> terms{{{}, at_node}};
  for (int a = 0; a < 3; ++a) {
    const auto there = unit_mass_at(unit(a)), opposite = unit_mass_at(-unit(a));
    terms.push_back({{{name + axes[a], 1}}, 0.5 * (there - opposite)});
    terms.push_back({{{name + axes[a], 2}}, 0.5 * (there + opposite) - at_node});
    for (int b = a + 1; b < 3; ++b)
      terms.push_back({{{name + axes[a], 1}, {name + axes[b], 1}},
                       unit_mass_at(unit(a) + unit(b)) - there - unit_mass_at(unit(b)) + at_node});
  }
  return terms;
}

}  // namespace kalfem
