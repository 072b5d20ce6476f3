// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/node_groups.hpp"

#include <algorithm>

namespace kalfem {

std::vector<Eigen::Index> nodes_of_group(const FiniteElementPart& part, const std::string& name) {
  const auto named = std::ranges::find(part.nodes, name, &NamedNode::name);
  if (named != part.nodes.end()) return {named->node};
  const auto group = part.elements.mesh.node_sets.find(name);
  return group == part.elements.mesh.node_sets.end() ? std::vector<Eigen::Index>{} : group->second;
}

std::vector<std::string> groups_of_nodes(const FiniteElementPart& part) {
  std::vector<std::string> names;
  for (const auto& node : part.nodes) names.push_back(node.name);
  for (const auto& [group, nodes] : part.elements.mesh.node_sets) names.push_back(group);
  return names;
}

bool is_held(const FiniteElementModel& model, const NodalDof& dof) {
  return std::ranges::any_of(model.fixed, [&](const FixedNodes& support) {
    return support.directions[static_cast<std::size_t>(dof.direction)] &&
           std::ranges::find(support.nodes, dof.node) != support.nodes.end();
  });
}

}  // namespace kalfem
