#pragma once

#include <array>
#include <optional>
#include <vector>

#include "kalfem/model/assembly/rigid_motion.hpp"
#include "kalfem/model/linear_model.hpp"

namespace kalfem {

/// One of the six rigid-body motions of a structure: along x, y, z, and about axes through its middle.
struct RigidMotion {
  bool exists = true;     ///< it moves any degree of freedom
  bool strained = false;  ///< it takes force, so something holds it
  double largest = 0.0;   ///< largest |(K r)_i| / sum_j |K_ij| |r_j|max over the degrees of freedom, in [0, 1]
};

/// A degree of freedom at which a rigid-body motion takes force though nothing holds it there.
struct StrayForce {
  Eigen::Index dof = 0;
  double ratio = 0.0;  ///< as RigidMotion::largest, of the worst combination of motions
};

/// How a structure is held.
struct GroundingCheck {
  std::array<RigidMotion, 6> motions;
  int existing = 0;               ///< independent rigid-body motions of the degrees of freedom
  int free = 0;                   ///< combinations of them that take no force
  std::vector<StrayForce> stray;  ///< the largest first, at most 10
  Eigen::Index stray_count = 0;
};

/// Applies the six rigid-body motions R (n x 6) to the stiffness: K R = 0 where nothing holds the structure. Rotations
/// are scaled by the size of the structure, so that all compare; rows below 1e-10 of what cancels in them count as
/// rounding. `held`: degrees of freedom at which force is expected, because they are next to a support or hang on a
/// ground; force of more than 1e-6 elsewhere is stray: elements or springs that resist a rigid motion, matrices that
/// were condensed wrongly, constraints that are no rigid body's.
GroundingCheck check_grounding(const SparseMatrix& stiffness, const Eigen::MatrixXd& rigid_motions,
                               const std::vector<bool>& held);

}  // namespace kalfem
