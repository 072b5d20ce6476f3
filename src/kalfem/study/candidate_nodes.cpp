// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/candidate_nodes.hpp"

#include <algorithm>
#include <charconv>
#include <set>

namespace kalfem {
namespace {

using Eigen::Index;

std::vector<Index> corners_of(const Mesh& mesh, const std::vector<Index>& cells) {
  std::set<Index> nodes;
  for (const auto index : cells) {
    const auto& cell = mesh.cells[static_cast<std::size_t>(index)];
    const auto corners = mesh.nodes_of(cell).first(static_cast<std::size_t>(corner_count(cell.shape)));
    nodes.insert(corners.begin(), corners.end());
  }
  return {nodes.begin(), nodes.end()};
}

/// Those that lie at least so far from all that were taken before.
std::vector<Index> thinned(const Mesh& mesh, const std::vector<Index>& nodes, double spacing) {
  std::vector<Index> taken;
  for (const auto node : nodes)
    if (std::ranges::all_of(
            taken, [&](Index other) { return (mesh.nodes.col(node) - mesh.nodes.col(other)).norm() >= spacing; }))
      taken.push_back(node);
  return taken;
}

/// Index of the node that "n12" names; -1 where there is none.
Index numbered_node(const Mesh& mesh, const std::string& name) {
  std::int64_t number = 0;
  if (name.size() < 2 || name.front() != 'n') return -1;
  const auto [end, error] = std::from_chars(name.data() + 1, name.data() + name.size(), number);
  return error == std::errc{} && end == name.data() + name.size() ? NodeFinder(mesh).find(number) : -1;
}

/// The motion of a node as a sum of the model's degrees of freedom; empty where it does not move.
DofCombination motion_of(const Eigen::SparseMatrix<double, Eigen::RowMajor>& expansion, const LinearModel& model,
                         Index node, int direction) {
  DofCombination motion;
  for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator it(expansion, 6 * node + direction); it; ++it)
    motion[model.dofs[static_cast<std::size_t>(it.col())]] = it.value();
  return motion;
}

}  // namespace

std::optional<CandidateNodes> candidate_nodes(const FiniteElementPart& part, const std::string& place, double spacing) {
  const auto dot = place.rfind('.');
  const int direction = dot == std::string::npos ? -1 : direction_index(place.substr(dot + 1));
  const std::string name = direction < 0 ? place : place.substr(0, dot);
  CandidateNodes found{.nodes = {}, .directions = {0, 1, 2}};
  if (direction >= 0) found.directions = {direction};
  const Mesh& mesh = part.elements.mesh;
  if (const auto named = std::ranges::find(part.nodes, name, &NamedNode::name); named != part.nodes.end())
    found.nodes = {named->node};
  else if (const Index node = numbered_node(mesh, name); node >= 0)
    found.nodes = {node};
  else if (const auto region = mesh.regions.find(name); region != mesh.regions.end())
    found = {thinned(mesh, corners_of(mesh, region->second), spacing), found.directions, true};
  else if (const auto group = mesh.node_sets.find(name); group != mesh.node_sets.end())
    found = {thinned(mesh, group->second, spacing), found.directions, true};
  else
    return std::nullopt;
  return found;
}

std::string name_of_node(const FiniteElementPart& part, Index node) {
  const auto named = std::ranges::find(part.nodes, node, &NamedNode::node);
  return named != part.nodes.end() ? named->name
                                   : "n" + std::to_string(part.elements.mesh.node_ids[static_cast<std::size_t>(node)]);
}

void add_candidate_points(const description::Case& given, FiniteElementPart& part) {
  if (!given.place) return;
  const Eigen::SparseMatrix<double, Eigen::RowMajor> expansion = part.assembled.expansion;
  const std::string prefix = part.name + ".";
  const auto add = [&](Index node, int direction) {
    const std::string point =
        name_of_node(part, node) + "." + std::string(direction_names[static_cast<std::size_t>(direction)]);
    auto motion = motion_of(expansion, part.full, node, direction);
    if (!motion.empty()) part.full.points.try_emplace(point, std::move(motion));
  };
  for (const auto& [name, group] : given.place->value.candidates)
    for (const auto& place : std::visit(
             [](const auto& observed) -> const std::vector<Name>& { return observed.points; }, group.value.observed)) {
      if (!place.value.starts_with(prefix)) continue;
      const auto found = candidate_nodes(part, place.value.substr(prefix.size()), group.value.spacing);
      if (!found) continue;
      for (const auto node : found->nodes)
        for (const int direction : found->directions) add(node, direction);
    }
}

}  // namespace kalfem
