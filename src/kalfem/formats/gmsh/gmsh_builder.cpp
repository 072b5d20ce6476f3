// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/gmsh/gmsh_builder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace kalfem {

// Element types of the MSH format. A type with a shape can be read; the others are known by name and number of nodes,
// so that they can be counted and refused in one message. `order` gives for each node of the cell its place in the
// file: Gmsh numbers the mid-side nodes of second-order solids in another order.
const GmshType* find_gmsh_type(std::int64_t number) {
  static const std::array types{
      GmshType{15, 0, 1, "point", CellShape::point1},
      GmshType{1, 1, 2, "line", CellShape::line2},
      GmshType{2, 2, 3, "triangle", CellShape::triangle3},
      GmshType{3, 2, 4, "quadrilateral", CellShape::quadrilateral4},
      GmshType{4, 3, 4, "tetrahedron", CellShape::tetrahedron4},
      GmshType{5, 3, 8, "hexahedron", CellShape::hexahedron8},
      GmshType{6, 3, 6, "prism", CellShape::wedge6},
      GmshType{7, 3, 5, "pyramid"},
      GmshType{8, 1, 3, "3-node line", CellShape::line3},
      GmshType{9, 2, 6, "6-node triangle", CellShape::triangle6},
      GmshType{10, 2, 9, "9-node quadrilateral"},
      GmshType{11, 3, 10, "10-node tetrahedron", CellShape::tetrahedron10, {0, 1, 2, 3, 4, 5, 6, 7, 9, 8}},
      GmshType{12, 3, 27, "27-node hexahedron"},
      GmshType{13, 3, 18, "18-node prism"},
      GmshType{14, 3, 14, "14-node pyramid"},
      GmshType{16, 2, 8, "8-node quadrilateral", CellShape::quadrilateral8},
      GmshType{17, 3, 20, "20-node hexahedron", CellShape::hexahedron20, {0,  1, 2,  3,  4,  5,  6,  7,  8,  11,
                                                                          13, 9, 16, 18, 19, 17, 10, 12, 14, 15}},
      GmshType{18, 3, 15, "15-node prism", CellShape::wedge15, {0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11}},
      GmshType{19, 3, 13, "13-node pyramid"},
      GmshType{20, 2, 9, "9-node triangle"},
      GmshType{21, 2, 10, "10-node triangle"},
      GmshType{22, 2, 12, "12-node triangle"},
      GmshType{23, 2, 15, "15-node triangle"},
      GmshType{24, 2, 15, "15-node triangle without inner nodes"},
      GmshType{25, 2, 21, "21-node triangle"},
      GmshType{26, 1, 4, "4-node line"},
      GmshType{27, 1, 5, "5-node line"},
      GmshType{28, 1, 6, "6-node line"},
      GmshType{29, 3, 20, "20-node tetrahedron"},
      GmshType{30, 3, 35, "35-node tetrahedron"},
      GmshType{31, 3, 56, "56-node tetrahedron"},
      GmshType{36, 2, 16, "16-node quadrilateral"},
      GmshType{37, 2, 25, "25-node quadrilateral"},
      GmshType{38, 2, 36, "36-node quadrilateral"},
      GmshType{92, 3, 64, "64-node hexahedron"},
      GmshType{93, 3, 125, "125-node hexahedron"},
  };
  const auto found = std::ranges::find(types, number, &GmshType::number);
  return found == types.end() ? nullptr : &*found;
}

void GmshBuilder::name_group(std::int64_t dimension, std::int64_t number, std::string name) {
  names_[{dimension, number}] = std::move(name);
}

// Groups are made when an element first belongs to one, so empty ones leave no region.
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
             "it must be a finite number in m", "correct the coordinates or mesh again");
  mesh_.node_ids.push_back(id);
  places_.push_back(place);
  node_starts_.push_back(start);
}

void GmshBuilder::finish_nodes() {
  has_nodes_ = true;
  lookup_ = NumberLookup(mesh_.node_ids);
  for (const auto& [later, earlier] : lookup_.repeated())
    in_.note(node_starts_[static_cast<std::size_t>(later)],
             "node " + std::to_string(mesh_.node_ids[static_cast<std::size_t>(later)]) + " is defined twice",
             "node numbers must be unique", "renumber the mesh");
  mesh_.nodes = Eigen::Map<const Eigen::Matrix3Xd>(places_.empty() ? nullptr : places_.front().data(), 3,
                                                   static_cast<Eigen::Index>(places_.size()));
}

// Cells of a type without a shape are only counted. Nodes that are missing are noted, and the cell is kept until
// finish() raises all problems at once.
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
               "this node is not in the mesh", "export the mesh again with all its nodes");
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
                 " (" + type->name + "); the first one is here",
             "supported: lines, triangles, quadrilaterals, tetrahedra, prisms and hexahedra of first order, or of "
             "second order without nodes inside faces",
             "mesh with order 1 (gmsh -order 1) or with Mesh.SecondOrderIncomplete = 1");
}

// Cells of the highest dimension that no physical group names go to the region "mesh". Those of lower dimension are
// the boundary of the others, which Gmsh saves too if it is asked to save all elements.
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
  tell_what_no_group_holds(grouped, highest);
}

void GmshBuilder::tell(std::size_t position, const std::string& what, const std::string& consequence) {
  notes_.add(in_.place(position), what, consequence, DeckNoteKind::unused);
}

void GmshBuilder::tell_what_no_group_holds(const std::vector<bool>& grouped, int highest) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < grouped.size(); ++i) count += !grouped[i] && dimension(mesh_.cells[i].shape) < highest;
  if (count > 0)
    tell(0, std::to_string(count) + " cells without a physical group",
         "they are of lower dimension than the mesh and taken for the boundary of its geometry");
}

void GmshBuilder::tell_empty_groups() {
  for (const auto& [key, name] : names_) {
    const auto index = group_indices_.find(key);
    if (index == group_indices_.end() || groups_[index->second].cells.empty())
      tell(0,
           "physical group '" + printable(name) + "' (dimension " + std::to_string(key.first) + ", number " +
               std::to_string(key.second) + ")",
           "no cell belongs to it: there is no region and no node set of this name");
  }
}

// Groups of the same name, even of different dimension, become one region. Each region also makes a node set, both
// sorted and without repetition.
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
  tell_empty_groups();
  add_cells_without_group();
  add_regions();
  return std::move(mesh_);
}

// Numbers that are dense are found by a table over lowest ... highest, at most about four entries for each number.
// Sparse ones are sorted and found by bisection, so that a single very large number costs no memory.
NumberLookup::NumberLookup(const std::vector<std::int64_t>& numbers) {
  if (numbers.empty()) return;
  const auto [lowest, highest] = std::ranges::minmax(numbers);
  lowest_ = lowest;
  // Unsigned, as the difference of two 64-bit numbers may not fit into a signed one.
  const std::uint64_t span = static_cast<std::uint64_t>(highest) - static_cast<std::uint64_t>(lowest);
  if (span / 4 <= numbers.size())
    fill_table(numbers, span);
  else
    sort_numbers(numbers);
}

void NumberLookup::fill_table(const std::vector<std::int64_t>& numbers, std::uint64_t span) {
  table_.assign(static_cast<std::size_t>(span) + 1, -1);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    Eigen::Index& entry = table_[static_cast<std::uint64_t>(numbers[i]) - static_cast<std::uint64_t>(lowest_)];
    if (entry < 0)
      entry = static_cast<Eigen::Index>(i);
    else
      repeated_.emplace_back(static_cast<Eigen::Index>(i), entry);
  }
}

void NumberLookup::sort_numbers(const std::vector<std::int64_t>& numbers) {
  sorted_.reserve(numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) sorted_.emplace_back(numbers[i], static_cast<Eigen::Index>(i));
  std::ranges::sort(sorted_);
  for (std::size_t i = 1; i < sorted_.size(); ++i)
    if (sorted_[i].first == sorted_[i - 1].first) repeated_.emplace_back(sorted_[i].second, sorted_[i - 1].second);
  std::ranges::sort(repeated_);
}

Eigen::Index NumberLookup::find(std::int64_t number) const {
  if (!table_.empty()) {
    const std::uint64_t position = static_cast<std::uint64_t>(number) - static_cast<std::uint64_t>(lowest_);
    return position < table_.size() ? table_[position] : -1;
  }
  const auto found = std::ranges::lower_bound(sorted_, number, {}, &std::pair<std::int64_t, Eigen::Index>::first);
  return found != sorted_.end() && found->first == number ? found->second : -1;
}

}  // namespace kalfem
