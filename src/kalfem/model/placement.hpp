// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/model/finite_element_model.hpp"
#include "kalfem/model/statics/load_case.hpp"

namespace kalfem {

/// A rigid motion of a whole model, x -> R (x - c) + c + s.
struct Placement {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< R, proper orthogonal
  Eigen::Vector3d about = Eigen::Vector3d::Zero();         ///< c [m]
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();         ///< s [m]

  [[nodiscard]] Eigen::Vector3d at(const Eigen::Vector3d& place) const {
    return rotation * (place - about) + about + shift;
  }
};

/// The turn by an angle [rad] about an axis of any length, by the right-hand rule; entries that are rounding are 0.
Eigen::Matrix3d turn_about(const Eigen::Vector3d& axis, double angle);

/// Moves a model and its load cases as one rigid body: nodes; orientations and offsets of beams, axes of laminates and
/// of solids; masses and matrices; links, constraints, springs and supports; forces, gravity, axes of rotation and
/// imposed motions. Its frequencies stay, and K becomes R K R^T.
///
/// What acts along single directions, as supports, springs, constraints and imposed motions do, keeps the directions of
/// the model's own axes. Where the model turns these are no longer global ones: the node then gets a local node, which
/// takes its place there, see add_local_node().
void place(FiniteElementModel& model, std::vector<LoadCase>& load_cases, const Placement& placement);

/// Adds a node at the place of `node`, of a number beyond all others, that has its motions along `axes` (columns). It
/// still moves by itself: local_motions() ties it.
Eigen::Index add_local_node(Mesh& mesh, Eigen::Index node, const Eigen::Matrix3d& axes);

/// u - axes q = 0, component by component: the motions u of `node` follow from those of its local node, q.
std::vector<MultiPointConstraint> local_motions(const Mesh& mesh, Eigen::Index node, Eigen::Index local);

}  // namespace kalfem
