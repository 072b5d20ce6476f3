// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/statics/load_places.hpp"

#include <algorithm>
#include <charconv>

namespace kalfem {

using Eigen::Index;

LoadPlaces::LoadPlaces(const FiniteElementModel& model, const std::vector<NamedNode>& nodes,
                       const std::map<std::string, std::vector<Index>>& groups)
    : model_(model), nodes_(nodes), groups_(groups), finder_(model.mesh) {}

std::optional<std::map<Index, double>> LoadPlaces::shares(const std::string& place) const {
  if (const auto* named = node(place)) return std::map{std::pair{named->node, 1.0}};
  if (const auto cells = groups_.find(place); cells != groups_.end()) return uniform_shares(model_.mesh, cells->second);
  if (const auto set = model_.mesh.node_sets.find(place); set != model_.mesh.node_sets.end()) {
    std::map<Index, double> equal;
    for (const auto each : set->second) equal[each] = 1.0 / static_cast<double>(set->second.size());
    return equal;
  }
  if (const Index found = numbered(place); found >= 0) return std::map{std::pair{found, 1.0}};
  return std::nullopt;
}

bool LoadPlaces::has_group(const std::string& name) const {
  return groups_.contains(name) || model_.mesh.node_sets.contains(name);
}

std::vector<LoadedFace> LoadPlaces::faces(const std::string& group) const {
  std::vector<LoadedFace> found;
  const auto cells = groups_.find(group);
  const auto set = model_.mesh.node_sets.find(group);
  if (cells != groups_.end()) found = faces_of_cells(model_, cells->second);
  if (found.empty() && set != model_.mesh.node_sets.end()) found = faces_between_nodes(model_, set->second);
  return found;
}

std::optional<NodalDof> LoadPlaces::dof(const std::string& name) const {
  const auto dot = name.rfind('.');
  const int direction = dot == std::string::npos ? -1 : direction_index(name.substr(dot + 1));
  const auto* named = node(name.substr(0, dot));
  if (direction < 0 || !named) return std::nullopt;
  return NodalDof{named->node, direction};
}

const NamedNode* LoadPlaces::node(const std::string& name) const {
  const auto named = std::ranges::find(nodes_, name, &NamedNode::name);
  return named == nodes_.end() ? nullptr : &*named;
}

std::string LoadPlaces::hint(const std::string& name) const {
  std::vector<std::string> known;
  for (const auto& each : nodes_) known.push_back(each.name);
  for (const auto& [group, members] : model_.mesh.node_sets) known.push_back(group);
  for (const auto& [region, property] : model_.properties) known.push_back(region);
  return did_you_mean(name.substr(0, name.rfind('.')), known);
}

Index LoadPlaces::numbered(const std::string& word) const {
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  return error == std::errc{} && end == word.data() + word.size() ? finder_.find(number) : -1;
}

bool add_force(const LoadPlaces& places, const std::string& place, const Eigen::Vector3d& force,
               const Eigen::Vector3d& moment, LoadCase& load_case) {
  const auto shares = places.shares(place);
  if (!shares) return false;
  for (const auto& [node, share] : *shares) load_case.loads.push_back({node, share * force, share * moment});
  return true;
}

}  // namespace kalfem
