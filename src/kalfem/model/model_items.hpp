#pragma once

#include <span>
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

}  // namespace kalfem
