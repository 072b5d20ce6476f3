// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <unordered_map>

#include "kalfem/model/finite_element_model.hpp"

namespace kalfem {

/// Directions in which supports, and constraints of one node alone, hold nodes.
class HeldMotions {
public:
  explicit HeldMotions(const FiniteElementModel& model);

  [[nodiscard]] bool empty() const { return held_.empty(); }
  /// Projection onto the held translations of a node, 0 where nothing holds it.
  [[nodiscard]] Eigen::Matrix3d translations(Eigen::Index node) const { return span(node, 0); }
  /// The same of its rotations.
  [[nodiscard]] Eigen::Matrix3d rotations(Eigen::Index node) const { return span(node, 1); }

private:
  [[nodiscard]] Eigen::Matrix3d span(Eigen::Index node, std::size_t block) const;
  void add(Eigen::Index node, int block, const Eigen::Vector3d& direction);

  std::unordered_map<Eigen::Index, std::array<Eigen::Matrix3d, 2>> held_;
};

/// Whether a constraint holds a translation, or a rotation, of one node along a direction, and does nothing else.
bool holds_one_node(const MultiPointConstraint& constraint);

}  // namespace kalfem
