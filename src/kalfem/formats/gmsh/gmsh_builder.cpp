#include "kalfem/formats/gmsh/gmsh_builder.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace kalfem {

void GmshBuilder::name_group(std::int64_t dimension, std::int64_t number, std::string name) {
  names_[{dimension, number}] = std::move(name);
}

std::size_t GmshBuilder::group(std::int64_t dimension, std::int64_t number) {
  // A negative number asks for cells of the other orientation; here they stay as the elements say.
  const std::pair key{dimension, number < 0 ? -number : number};
  const auto [entry, is_new] = group_indices_.try_emplace(key, groups_.size());
  if (is_new) {
    const auto name = names_.find(key);
    groups_.push_back({name == names_.end() ? "physical" + std::to_string(key.second) : name->second, {}});
  }
  return entry->second;
}

void GmshBuilder::reserve_nodes(std::int64_t count) {
  const auto size = static_cast<std::size_t>(count);
  mesh_.node_ids.reserve(size);
  places_.reserve(size);
  node_starts_.reserve(size);
}

void GmshBuilder::add_node(std::int64_t id, const Eigen::Vector3d& place, std::size_t start) {
  if (!place.allFinite())
    in_.note(start, "node " + std::to_string(id) + " has a coordinate that is not finite",
             "it must be a finite number in m", "mend the coordinates or mesh again");
  mesh_.node_ids.push_back(id);
  places_.push_back(place);
  node_starts_.push_back(start);
}

void GmshBuilder::finish_nodes() {
  has_nodes_ = true;
  lookup_ = NumberLookup(mesh_.node_ids);
  for (const auto& [later, earlier] : lookup_.repeated())
    in_.note(node_starts_[static_cast<std::size_t>(later)],
             "node " + std::to_string(mesh_.node_ids[static_cast<std::size_t>(later)]) + " is given a second time",
             "node numbers must differ", "renumber the mesh");
  mesh_.nodes = Eigen::Map<const Eigen::Matrix3Xd>(places_.empty() ? nullptr : places_.front().data(), 3,
                                                   static_cast<Eigen::Index>(places_.size()));
}

void GmshBuilder::add_element(const GmshType& type, std::int64_t id, std::span<const std::int64_t> nodes,
                              std::span<const std::size_t> groups, std::size_t start) {
  if (!type.shape) {
    Refused& refused = refused_[&type];
    if (refused.count++ == 0) refused.first = start;
    return;
  }
  found_.clear();
  for (const auto node : nodes) {
    found_.push_back(lookup_.find(node));
    if (found_.back() < 0)
      in_.note(start, "element " + std::to_string(id) + " names the node " + std::to_string(node),
               "the mesh has no such node", "write the mesh again with all its nodes");
  }
  if (type.order != decltype(type.order){}) {
    const auto in_file = found_;
    for (std::size_t i = 0; i < found_.size(); ++i) found_[i] = in_file[static_cast<std::size_t>(type.order[i])];
  }
  const Eigen::Index cell = mesh_.add_cell(*type.shape, id, found_);
  for (const auto group : groups) groups_[group].cells.push_back(cell);
}

void GmshBuilder::add_last_to(std::size_t group) {
  groups_[group].cells.push_back(static_cast<Eigen::Index>(mesh_.cells.size()) - 1);
}

void GmshBuilder::note_refused() {
  for (const auto& [type, refused] : refused_)
    in_.note(refused.first,
             "the mesh has " + std::to_string(refused.count) + " cells of Gmsh type " + std::to_string(type->number) +
                 " (" + type->name + "), the first of them here",
             "lines, triangles, quadrilaterals, tetrahedra, prisms and hexahedra of first order or of second order "
             "without nodes inside faces can be read",
             "mesh with order 1 (gmsh -order 1) or with Mesh.SecondOrderIncomplete = 1");
}

void GmshBuilder::add_cells_without_group() {
  int highest = 1;
  for (const auto& cell : mesh_.cells) highest = std::max(highest, dimension(cell.shape));
  std::vector<bool> grouped(mesh_.cells.size(), false);
  for (const auto& group : groups_)
    for (const auto cell : group.cells) grouped[static_cast<std::size_t>(cell)] = true;
  Group rest{"mesh", {}};
  for (std::size_t i = 0; i < grouped.size(); ++i)
    if (!grouped[i] && dimension(mesh_.cells[i].shape) == highest) rest.cells.push_back(static_cast<Eigen::Index>(i));
  groups_.push_back(std::move(rest));
}

void GmshBuilder::add_regions() {
  for (const auto& group : groups_) {
    if (group.cells.empty()) continue;
    auto& cells = mesh_.regions[group.name];
    cells.insert(cells.end(), group.cells.begin(), group.cells.end());
  }
  std::vector<bool> marked;
  for (auto& [name, cells] : mesh_.regions) {
    std::ranges::sort(cells);
    cells.erase(std::ranges::unique(cells).begin(), cells.end());
    marked.assign(mesh_.node_ids.size(), false);
    auto& set = mesh_.node_sets[name];
    for (const auto cell : cells)
      for (const auto node : mesh_.nodes_of(mesh_.cells[static_cast<std::size_t>(cell)])) {
        if (!marked[static_cast<std::size_t>(node)]) set.push_back(node);
        marked[static_cast<std::size_t>(node)] = true;
      }
    std::ranges::sort(set);
  }
}

Mesh GmshBuilder::finish() {
  note_refused();
  in_.raise();
  add_cells_without_group();
  add_regions();
  return std::move(mesh_);
}

}  // namespace kalfem
