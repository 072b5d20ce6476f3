// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/assembly/held_motions.hpp"

#include <algorithm>

namespace kalfem {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

bool holds_one_node(const MultiPointConstraint& constraint) {
  const auto& terms = constraint.terms;
  return !terms.empty() && std::ranges::all_of(terms, [&](const auto& term) {
    const NodalDof &first = terms.front().first, &dof = term.first;
    return dof.node == first.node && dof.direction / 3 == first.direction / 3;
  });
}

HeldMotions::HeldMotions(const FiniteElementModel& model) {
  for (const auto& support : model.fixed)
    for (const auto node : support.nodes)
      for (int i = 0; i < 6; ++i)
        if (support.directions[static_cast<std::size_t>(i)]) add(node, i / 3, Vector3d::Unit(i % 3));
  for (const auto& constraint : model.constraints) {
    if (!holds_one_node(constraint)) continue;
    Vector3d along = Vector3d::Zero();
    for (const auto& [dof, coefficient] : constraint.terms) along[dof.direction % 3] += coefficient;
    const NodalDof& first = constraint.terms.front().first;
    add(first.node, first.direction / 3, along);
  }
}

Matrix3d HeldMotions::span(Index node, std::size_t block) const {
  const auto own = held_.find(node);
  return own == held_.end() ? Matrix3d(Matrix3d::Zero()) : own->second[block];
}

void HeldMotions::add(Index node, int block, const Vector3d& direction) {
  auto& spans =
      held_.try_emplace(node, std::array{Matrix3d(Matrix3d::Zero()), Matrix3d(Matrix3d::Zero())}).first->second;
  Matrix3d& span = spans[static_cast<std::size_t>(block)];
  const Vector3d rest = direction - span * direction;
  if (rest.norm() > 1e-9 * direction.norm()) span += rest.normalized() * rest.normalized().transpose();
}

}  // namespace kalfem
