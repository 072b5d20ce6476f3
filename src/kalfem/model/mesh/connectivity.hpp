// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "kalfem/model/finite_element_model.hpp"

namespace kalfem {

/// Calls visit(nodes) with the nodes of each thing that a model is made of: cells with a property, point masses,
/// springs, joints, matrices, links and constraints; not supports. Cells and nodes must exist.
template <typename Visit>
void visit_items(const FiniteElementModel& model, const Visit& visit) {
  std::vector<Eigen::Index> nodes;
  const auto call = [&] {
    visit(std::span<const Eigen::Index>(nodes));
    nodes.clear();
  };
  for (const auto& [region, property] : model.properties)
    if (const auto cells = model.mesh.regions.find(region); cells != model.mesh.regions.end())
      for (const auto cell : cells->second)
        visit(model.mesh.nodes_of(model.mesh.cells[static_cast<std::size_t>(cell)]));
  for (const auto& mass : model.masses) {
    nodes = {mass.node};
    call();
  }
  for (const auto& spring : model.springs) {
    nodes = {spring.from.node};
    if (spring.to) nodes.push_back(spring.to->node);
    call();
  }
  for (const auto& joint : model.joints) {
    for (const auto& [dof, coefficient] : joint.deformation) nodes.push_back(dof.node);
    call();
  }
  for (const auto& item : model.matrices) {
    for (const auto& dof : item.dofs) nodes.push_back(dof.node);
    call();
  }
  for (const auto& link : model.links) {
    nodes = link.slaves;
    nodes.push_back(link.master);
    call();
  }
  for (const auto& link : model.weighted_links) {
    for (const auto& share : link.shares) nodes.push_back(share.node);
    nodes.push_back(link.follower);
    call();
  }
  for (const auto& constraint : model.constraints) {
    for (const auto& [dof, coefficient] : constraint.terms) nodes.push_back(dof.node);
    call();
  }
}

/// Parts of a model joined by cells that have a property, rigid links, constraints and springs between nodes: the nodes
/// of each part, ascending, the largest part first. Nodes that nothing touches belong to no part. A spring to ground
/// and a support join nothing.
std::vector<std::vector<Eigen::Index>> connected_parts(const FiniteElementModel& model);

/// Whether a model falls into parts of which one hangs on nothing: it has no support, no spring to a ground and no
/// constraint of one node alone, and `joined`, the nodes at which something outside the model acts, holds none of its
/// nodes. `parts`: connected_parts() of the model.
bool has_loose_parts(const FiniteElementModel& model, const std::vector<std::vector<Eigen::Index>>& parts,
                     const std::vector<Eigen::Index>& joined);

/// Throws InvalidInput where the model has loose parts: names each part by its number of nodes, one node and the region
/// that it lies in. Returns whether there are several parts of which one is joined from outside alone.
bool require_connected(const FiniteElementModel& model, const std::vector<Eigen::Index>& joined = {});

/// Pairs of nodes (by index, the lower first) that are nearer to each other than `tolerance` [m], of those marked; by a
/// hash of a grid, in a time that grows with the number of nodes. Of many nodes at one place, each is paired with at
/// most `most_partners` others.
std::vector<std::pair<Eigen::Index, Eigen::Index>> coincident_nodes(const Eigen::Matrix3Xd& places,
                                                                    const std::vector<bool>& marked, double tolerance,
                                                                    int most_partners = 8);

/// Which of the pairs something joins directly: a cell with a property, a link, constraint, spring, joint or matrix
/// that names both nodes.
std::vector<bool> directly_joined(const FiniteElementModel& model,
                                  const std::vector<std::pair<Eigen::Index, Eigen::Index>>& pairs);

}  // namespace kalfem
