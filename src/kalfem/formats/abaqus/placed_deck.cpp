// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/abaqus/placed_deck.hpp"

#include <algorithm>
#include <numbers>

#include "kalfem/formats/abaqus/raw_deck.hpp"

namespace kalfem::abaqus {

namespace {

/// Numbers of a line of exactly so many; nothing where they are not.
std::optional<Eigen::VectorXd> numbers_of(const DataLine& line, std::size_t least, std::size_t most) {
  if (line.fields.size() < least || line.fields.size() > most) return {};
  Eigen::VectorXd values(static_cast<Index>(line.fields.size()));
  for (std::size_t i = 0; i < line.fields.size(); ++i) {
    const auto value = line.fields[i].empty() ? 0.0 : to_number(line.fields[i]);
    if (!value) return {};
    values[static_cast<Index>(i)] = *value;
  }
  return values;
}

}  // namespace

// A deck of parts and instances becomes one mesh: places are made (the deck outside of instances is the first), numbers
// that collide are raised, nodes are moved by their instance, elements are listed with their scope and place.
PlacedDeck::PlacedDeck(const RawDeck& raw, Mesh& deck_mesh, DeckNotes& deck_notes, Problems& deck_problems)
    : mesh(deck_mesh), notes(deck_notes), problems(deck_problems), raw_(raw) {
  make_places();
  number_places();
  for (auto& place : places_) add_nodes(place);
  mesh.nodes.conservativeResize(3, static_cast<Index>(mesh.node_ids.size()));
  for (int place = 0; place < place_count(); ++place) add_elements(place);
}

void PlacedDeck::make_places() {
  places_.push_back({"", {&raw_.root}, Eigen::Isometry3d::Identity(), {}, {}, 0});
  for (const auto& instance : raw_.instances) {
    Place place{instance.name, {}, motion_of(instance), {}, {}, 0};
    const auto part = raw_.parts.find(upper_case(instance.part));
    if (part != raw_.parts.end())
      place.scopes.push_back(&part->second);
    else if (!instance.part.empty())
      problems.add(instance.where,
                   "the instance '" + to_string(instance.name) + "' refers to the unknown part '" +
                       to_string(instance.part) + "'",
                   "", "define it by *PART, NAME=" + to_string(instance.part));
    place.scopes.push_back(&instance.own);
    places_.push_back(std::move(place));
  }
}

/// A translation, then a rotation about the line from a to b by an angle in degrees; both may be left out.
Eigen::Isometry3d PlacedDeck::motion_of(const RawInstance& instance) {
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  if (instance.placement.size() > 2)
    problems.add(instance.placement[2].where, "*INSTANCE has more than two data lines",
                 "it takes a translation and a rotation", "remove the line");
  for (std::size_t i = 0; i < std::min<std::size_t>(2, instance.placement.size()); ++i) {
    const auto& line = instance.placement[i];
    const auto values = i == 0 ? numbers_of(line, 1, 3) : numbers_of(line, 7, 7);
    if (!values) {
      problems.add(line.where, "the line cannot be read",
                   "*INSTANCE expects a translation (x, y, z), then a rotation (a, b and an angle: 7 numbers)");
      return motion;
    }
    if (i == 0) {
      motion.translation().head(values->size()) = *values;
      continue;
    }
    const Eigen::Vector3d a = values->head<3>(), axis = values->segment<3>(3) - a;
    if (!(axis.norm() > 0.0)) {
      problems.add(line.where, "the points of the axis of rotation coincide", "they must define a direction",
                   "correct them");
      return motion;
    }
    const Eigen::Isometry3d turn = Eigen::Translation3d(a) *
                                   Eigen::AngleAxisd((*values)[6] * std::numbers::pi / 180.0, axis.normalized()) *
                                   Eigen::Translation3d(-a);
    motion = turn * motion;
  }
  return motion;
}

// If numbers of two places collide, the first instance keeps its numbers, and each further one adds a multiple of a
// power of ten beyond every number of the deck. The numbers stay readable: 1000042 is node 42 of the second instance.
// Nodes outside of instances come last.
/// Numbers of instances are raised where those of two places collide.
void PlacedDeck::number_places() {
  std::vector<std::int64_t> node_labels, element_labels;
  for (const auto& place : places_) {
    std::vector<std::int64_t> own;
    for (const Scope* scope : place.scopes)
      own.insert(own.end(), scope->nodes.labels.begin(), scope->nodes.labels.end());
    if (places_.size() > 1) {  // a number given twice in one place is no collision
      std::ranges::sort(own);
      own.erase(std::unique(own.begin(), own.end()), own.end());
    }
    node_labels.insert(node_labels.end(), own.begin(), own.end());
    for (const Scope* scope : place.scopes)
      for (const auto& element : scope->elements) element_labels.push_back(element.label);
  }
  mesh.node_ids.reserve(node_labels.size());
  mesh.nodes.resize(3, static_cast<Index>(node_labels.size()));
  elements.reserve(element_labels.size());
  if (places_.size() == 1) return;
  const auto collide = [](std::vector<std::int64_t>& labels) {
    std::ranges::sort(labels);
    return std::ranges::adjacent_find(labels) != labels.end();
  };
  const bool nodes_collide = collide(node_labels), elements_collide = collide(element_labels);
  if (!nodes_collide && !elements_collide) return;
  const std::int64_t largest =
      std::max(node_labels.empty() ? 0 : node_labels.back(), element_labels.empty() ? 0 : element_labels.back());
  std::int64_t unit = 10;
  while (unit <= largest && unit < std::int64_t{1000000000000}) unit *= 10;
  for (std::size_t i = 2; i < places_.size(); ++i) places_[i].raised_by = static_cast<std::int64_t>(i - 1) * unit;
  if (!raw_.root.nodes.labels.empty() || !raw_.root.elements.empty())
    places_[0].raised_by = static_cast<std::int64_t>(places_.size() - 1) * unit;
  for (std::size_t i = 0; i < places_.size(); ++i)
    if (places_[i].raised_by > 0)
      notes.add(problems.location({}),
                i == 0 ? "nodes and elements outside instances" : "instance '" + places_[i].name + "'",
                "their numbers are raised by " + std::to_string(places_[i].raised_by) +
                    ", because numbers of the deck's parts collide",
                DeckNoteKind::unused);
}

// The number and the largest of the labels are counted first, as the lookup by label chooses its form by them.
void PlacedDeck::add_nodes(Place& place) {
  std::size_t count = 0;
  std::int64_t largest = 0;
  for (const Scope* scope : place.scopes) {
    count += scope->nodes.labels.size();
    for (const auto label : scope->nodes.labels) largest = std::max(largest, label);
  }
  place.nodes.prepare(count, largest);
  for (const Scope* scope : place.scopes) {
    const auto& nodes = scope->nodes;
    for (std::size_t i = 0; i < nodes.labels.size(); ++i) {
      const Eigen::Vector3d position = place.motion * Eigen::Map<const Eigen::Vector3d>(&nodes.coordinates[3 * i]);
      if (const auto earlier = place.nodes.find(nodes.labels[i]); earlier >= 0) {
        if ((mesh.nodes.col(earlier) - position).norm() > 1e-9 * position.norm())
          problems.add(nodes.places[i],
                       "node " + std::to_string(nodes.labels[i]) + " is defined again with other coordinates",
                       "a node can have only one place", "renumber one of them");
        continue;
      }
      const auto index = static_cast<Index>(mesh.node_ids.size());
      if (mesh.nodes.cols() <= index) mesh.nodes.conservativeResize(3, 2 * index + 1);
      mesh.nodes.col(index) = position;
      mesh.node_ids.push_back(nodes.labels[i] + place.raised_by);
      place.nodes.add(nodes.labels[i], index);
    }
  }
}

void PlacedDeck::add_elements(int index) {
  Place& place = places_[static_cast<std::size_t>(index)];
  std::size_t count = 0;
  std::int64_t largest = 0;
  for (const Scope* scope : place.scopes) {
    count += scope->elements.size();
    for (const auto& element : scope->elements) largest = std::max(largest, element.label);
  }
  place.elements.prepare(count, largest);
  for (const Scope* scope : place.scopes)
    for (const auto& element : scope->elements) {
      if (const auto earlier = place.elements.find(element.label); earlier >= 0) {
        problems.add(element.where, "element " + std::to_string(element.label) + " is defined twice",
                     "the first definition is in line " +
                         std::to_string(elements[static_cast<std::size_t>(earlier)].raw->where.line),
                     "renumber or remove one of them");
        continue;
      }
      place.elements.add(element.label, static_cast<std::int64_t>(elements.size()));
      elements.push_back({&element, scope, index, -1, -1});
    }
}

// Connectivity holds node numbers. A negative one points to a name, such as INSTANCE.12, which must lead to exactly
// one node.
bool PlacedDeck::nodes_of(const PlacedElement& element, std::vector<Index>& nodes) {
  nodes.clear();
  const int count = type_of(element).nodes + (element.raw->extra_node >= 0 ? 1 : 0);
  const auto& connectivity = element.scope->connectivity;
  for (int i = 0; i < count; ++i) {
    const std::int64_t label = connectivity[static_cast<std::size_t>(element.raw->first + i)];
    if (label < 0) {
      const auto found = node_list(element.scope->named_nodes[static_cast<std::size_t>(-1 - label)], element.place);
      if (found.size() != 1) return false;
      nodes.push_back(found.front());
      continue;
    }
    const auto node = place(element.place).nodes.find(label);
    if (node < 0) {
      problems.add(
          element.raw->where,
          "element " + std::to_string(element.raw->label) + " refers to the unknown node " + std::to_string(label),
          "every node of an element must be defined by *NODE", "add the node or correct the element");
      return false;
    }
    nodes.push_back(node);
  }
  return true;
}

std::string PlacedDeck::element_name(const PlacedElement& element) const {
  return place(element.place).full_name(std::to_string(element.raw->label));
}

// Instances come in their order, the deck outside of them last.
std::vector<PlacedBlock> PlacedDeck::blocks(std::string_view keyword) const {
  std::vector<PlacedBlock> found;
  for (int i = 1; i <= place_count(); ++i) {
    const int index = i % place_count();
    for (const Scope* scope : place(index).scopes)
      for (const auto& block : scope->blocks)
        if (block.keyword.name == keyword) found.push_back({&block, index});
  }
  return found;
}

// Looks in the same place, then in the deck outside of instances, then for INSTANCE.NAME. Names may contain dots, so
// each dot is tried as the end of the instance's name.
PlacedBlock PlacedDeck::find_block(std::string_view keyword, const std::string& name, int start) const {
  const std::string wanted = upper_case(name);
  const auto in_place = [&](int index, const std::string& own) -> PlacedBlock {
    for (const Scope* scope : place(index).scopes)
      for (const auto& block : scope->blocks)
        if (block.keyword.name == keyword && upper_case(block.keyword.get("NAME")) == own) return {&block, index};
    return {};
  };
  if (const auto found = in_place(start, wanted); found.block) return found;
  if (start != 0)
    if (const auto found = in_place(0, wanted); found.block) return found;
  for (auto dot = wanted.find('.'); dot != std::string::npos; dot = wanted.find('.', dot + 1))
    if (const int index = place_named(std::string_view(wanted).substr(0, dot)); index >= 0)
      if (const auto found = in_place(index, wanted.substr(dot + 1)); found.block) return found;
  return {};
}

int PlacedDeck::place_named(std::string_view name) const {
  const std::string wanted = upper_case(name);
  for (int i = 1; i < place_count(); ++i)
    if (upper_case(place(i).name) == wanted) return i;
  return -1;
}

}  // namespace kalfem::abaqus
