// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <span>
#include <string>
#include <utility>
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
  Eigen::Vector3d place = Eigen::Vector3d::Zero();     ///< [m]
  int direction = -1;                                  ///< 0 .. 5; -1: a generalised coordinate, which has no place
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< whose columns it is along
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

/// A part R^T M R of the structure's mass in the motions R of a rigid body about the origin: translations along x, y, z
/// [m/m] and rotations about them [m/rad]. It counts every node, held or not.
struct RigidMass {
  std::map<std::string, int> powers;  ///< of parameters, as those of an AffineTerm
  Matrix6 matrix = Matrix6::Zero();   ///< per unit of them [kg, kg m, kg m^2]
};

/// Sums up the mass of elements, point masses and matrices before supports and links take degrees of freedom away.
class RigidMassSum {
public:
  using Powers = std::map<std::string, int>;

  explicit RigidMassSum(const Mesh& mesh);

  /// R^T M R of a small mass matrix over the first `motions` degrees of freedom of each of the nodes.
  [[nodiscard]] Matrix6 of(std::span<const Eigen::Index> nodes, int motions, const Eigen::MatrixXd& mass) const;
  /// The same of a matrix over degrees of freedom; those of scalar points do not move with a rigid body.
  [[nodiscard]] Matrix6 of(const std::vector<NodalDof>& dofs, const Eigen::SparseMatrix<double>& mass) const;

  void add(const Powers& powers, const Matrix6& part) {
    sums_.try_emplace(powers, Matrix6::Zero()).first->second += part;
  }
  [[nodiscard]] std::vector<RigidMass> list() const;

private:
  const Mesh& mesh_;
  std::vector<bool> is_scalar_;  ///< by node
  std::map<Powers, Matrix6> sums_;
};

/// The rigid motion about a weighted link's follower that fits what it follows best in the sense of weighted least
/// squares: with the rows R of the components z that it follows (of rigid motion, see RigidRow) and their weights W,
///   q = (R^T W R)^+ R^T W z.
class MeanMotion {
public:
  /// Axes of a node's own, as columns, along which its directions are counted.
  using Axes = std::function<Eigen::Matrix3d(Eigen::Index)>;

  explicit MeanMotion(const Mesh& mesh, const WeightedLink& link, const Axes& axes = {});

  /// Components that the follower follows; a direction is along the axes of its node.
  [[nodiscard]] const std::vector<NodalDof>& components() const { return components_; }
  /// The component `row` q of a point that moves with the follower, by those components.
  [[nodiscard]] Eigen::RowVectorXd shares(const RigidRow& row) const { return row * fit_; }
  /// Whether they determine it: nodes on one line do not tell the rotation about it.
  [[nodiscard]] bool determines(const RigidRow& row) const;
  /// The same of the follower's own motion in a global direction; parts that are rounding are left out.
  [[nodiscard]] DofSum follower_motion(int direction) const;
  [[nodiscard]] bool determines(int direction) const {
    return determines(rigid_row(direction, Eigen::Vector3d::Zero()));
  }

private:
  double length_;  ///< mean distance of the nodes from the follower; 1 where all lie there [m]
  std::vector<NodalDof> components_;
  Eigen::Matrix<double, 6, Eigen::Dynamic> fit_;
  Matrix6 resolution_;  ///< projector onto what the components show, of rotations times the length
};

/// Mass of a body at a node, its centre off the node by o (parallel axes): with the cross-product matrix [o],
///     M = [m 1, -m [o]; m [o], J - m [o][o]],   6 x 6 in the node's degrees of freedom, global axes.
Eigen::Matrix<double, 6, 6> point_mass(const PointMass& mass);

/// point_mass() of 1 kg without inertia.
Eigen::Matrix<double, 6, 6> unit_mass_at(const Eigen::Vector3d& offset);

/// The same as a sum over the powers of "<name>.offset_x", ".offset_y" and ".offset_z":
///     M(o) = M_0 + sum_a o_a L_a + sum_(a <= b) o_a o_b Q_ab.
std::vector<std::pair<std::map<std::string, int>, Eigen::MatrixXd>> unit_mass_by_offset(const std::string& name);

}  // namespace kalfem
