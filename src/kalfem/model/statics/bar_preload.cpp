// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/statics/bar_preload.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/model/assembly/constraints.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

double deformation_of(const DofSum& terms, const VectorXd& displacements) {
  double sum = 0.0;
  for (const auto& [dof, coefficient] : terms) sum += coefficient * displacements[all_index(dof)];
  return sum;
}

/// The two nodes of a bar.
std::pair<Index, Index> ends_of(const JointSpring& bar) {
  const Index first = bar.deformation.front().first.node;
  const auto other = std::ranges::find_if(bar.deformation, [&](const auto& term) { return term.first.node != first; });
  return {first, other == bar.deformation.end() ? first : other->first.node};
}

/// A spring or matrices with the force that they carry.
struct LoadedSpring {
  std::string name;
  double force = 0.0;
  bool stiffens = false;  ///< it is a bar, or has no length
};

bool are_at_one_place(const Mesh& mesh, const std::vector<NodalDof>& dofs) {
  return std::ranges::all_of(dofs, [&](const NodalDof& dof) {
    return (mesh.nodes.col(dof.node) - mesh.nodes.col(dofs.front().node)).norm() == 0.0;
  });
}

std::vector<LoadedSpring> loaded_springs(const FiniteElementModel& model, const VectorXd& displacements) {
  std::vector<LoadedSpring> all;
  for (const auto& spring : model.springs) {
    DofSum terms{{spring.from, 1.0}};
    if (spring.to) terms.push_back({*spring.to, -1.0});
    all.push_back({spring.name, spring.stiffness * deformation_of(terms, displacements),
                   !spring.to || are_at_one_place(model.mesh, {spring.from, *spring.to})});
  }
  for (const auto& joint : model.joints) {
    std::vector<NodalDof> dofs;
    for (const auto& [dof, coefficient] : joint.deformation) dofs.push_back(dof);
    all.push_back({joint.name, joint.stiffness * deformation_of(joint.deformation, displacements),
                   joint.is_bar || are_at_one_place(model.mesh, dofs)});
  }
  for (const auto& item : model.matrices) {
    if (item.stiffness.size() == 0) continue;
    VectorXd own(static_cast<Index>(item.dofs.size()));
    for (std::size_t i = 0; i < item.dofs.size(); ++i)
      own[static_cast<Index>(i)] = displacements[all_index(item.dofs[i])];
    all.push_back(
        {item.name, VectorXd(item.stiffness * own).lpNorm<Eigen::Infinity>(), are_at_one_place(model.mesh, item.dofs)});
  }
  return all;
}

}  // namespace

SparseMatrix bar_preload_stiffness(const FiniteElementModel& model, const VectorXd& displacements) {
  std::vector<Eigen::Triplet<double>> entries;
  for (const auto& bar : model.joints) {
    if (!bar.is_bar || bar.deformation.empty()) continue;
    const auto [one, other] = ends_of(bar);
    const Eigen::Vector3d along = model.mesh.nodes.col(other) - model.mesh.nodes.col(one);
    const double length = along.norm();
    const double force = bar.stiffness * deformation_of(bar.deformation, displacements);
    if (force == 0.0 || !(length > 0.0)) continue;
    const Eigen::Vector3d t = along / length;
    const Eigen::Matrix3d across = force / length * (Eigen::Matrix3d::Identity() - t * t.transpose());
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        for (const auto& [row, column, sign] :
             {std::tuple{one, one, 1.0}, {other, other, 1.0}, {one, other, -1.0}, {other, one, -1.0}})
          entries.emplace_back(static_cast<int>(6 * row + i), static_cast<int>(6 * column + j), sign * across(i, j));
  }
  SparseMatrix sum(6 * model.mesh.node_count(), 6 * model.mesh.node_count());
  sum.setFromTriplets(entries.begin(), entries.end());
  return sum;
}

std::vector<std::string> springs_without_preload(const FiniteElementModel& model, const VectorXd& displacements) {
  constexpr double negligible = 1e-9;
  const auto all = loaded_springs(model, displacements);
  double largest = 0.0;
  for (const auto& each : all) largest = std::max(largest, std::abs(each.force));
  std::vector<std::string> names;
  for (const auto& each : all)
    if (!each.stiffens && std::abs(each.force) > negligible * largest) names.push_back(each.name);
  return names;
}

}  // namespace kalfem
