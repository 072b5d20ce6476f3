#pragma once

#include <functional>
#include <vector>

#include "kalfem/model/assembly/rigid_motion.hpp"

namespace kalfem {

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

}  // namespace kalfem
