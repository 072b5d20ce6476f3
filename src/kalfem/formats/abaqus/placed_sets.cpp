// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "kalfem/formats/abaqus/placed_deck.hpp"
#include "kalfem/formats/abaqus/raw_deck.hpp"

namespace kalfem::abaqus {

namespace {
constexpr std::size_t deepest_nesting = 200;
}

/// In the place itself, in the deck outside of instances, by the name of an instance, or in the only place that has
/// one.
PlacedDeck::Found PlacedDeck::find_set(Sets sets, const std::string& name, int start) const {
  const std::string wanted = upper_case(name);
  const auto in_place = [&](int index, const std::string& own) -> Found {
    for (const Scope* scope : place(index).scopes)
      if (const auto set = (scope->*sets).find(own); set != (scope->*sets).end()) return {&set->second, index};
    return {};
  };
  if (const auto found = in_place(start, wanted); found.set) return found;
  if (start != 0)
    if (const auto found = in_place(0, wanted); found.set) return found;
  for (auto dot = wanted.find('.'); dot != std::string::npos; dot = wanted.find('.', dot + 1))
    if (const int index = place_named(std::string_view(wanted).substr(0, dot)); index >= 0)
      if (const auto found = in_place(index, wanted.substr(dot + 1)); found.set) return found;
  if (start != 0) return {};
  Found only;
  for (int index = 1; index < place_count(); ++index)
    if (const auto found = in_place(index, wanted); found.set) {
      if (only.set) return {};
      only = found;
    }
  return only;
}

bool PlacedDeck::is_node_set(const std::string& name, int start) const {
  return find_set(&Scope::node_sets, name, start).set != nullptr;
}

bool PlacedDeck::is_element_set(const std::string& name, int start) const {
  return find_set(&Scope::element_sets, name, start).set != nullptr;
}

std::string PlacedDeck::spelled_set(const std::string& name, int start, bool of_nodes) const {
  const auto found = find_set(of_nodes ? &Scope::node_sets : &Scope::element_sets, name, start);
  return found.set ? place(found.place).full_name(found.set->name) : name;
}

std::vector<Index> PlacedDeck::node_list(const SetReference& reference, int start) {
  return list(&Scope::node_sets, reference, start);
}

std::vector<Index> PlacedDeck::element_list(const SetReference& reference, int start) {
  return list(&Scope::element_sets, reference, start);
}

// A name is looked up as a set, then as INSTANCE.NUMBER or a plain number; names of instances may hold dots, so each
// dot is tried as the end of one.
std::vector<Index> PlacedDeck::list(Sets sets, const SetReference& reference, int start) {
  const bool of_nodes = sets == &Scope::node_sets;
  if (const auto found = find_set(sets, reference.text, start); found.set) return flattened(sets, found, reference);
  int index = start;
  std::string own = reference.text;
  for (auto dot = own.find('.'); dot != std::string::npos; dot = own.find('.', dot + 1))
    if (const int named = place_named(std::string_view(own).substr(0, dot)); named >= 0) {
      index = named;
      own = own.substr(dot + 1);
      break;
    }
  if (const auto label = to_integer(own)) {
    if (const auto position = index_of(sets, index).find(*label); position >= 0) return {position};
    problems.add(reference.where,
                 std::string(of_nodes ? "node " : "element ") + to_string(reference.text) + " does not exist", "",
                 "correct the number");
    return {};
  }
  problems.add(reference.where,
               std::string("there is no set of ") + (of_nodes ? "nodes '" : "elements '") + to_string(reference.text) +
                   "'" + did_you_mean(reference.text, known_names(sets)),
               "", "define it or correct the name");
  return {};
}

// Sets can contain sets, so members are gathered recursively and kept for the next use. The sets that are being
// flattened stand on a stack: one that is met again contains itself.
/// Members in their order, each once.
const std::vector<Index>& PlacedDeck::flattened(Sets sets, const Found& found, const SetReference& reference) {
  static const std::vector<Index> none;
  const std::pair key{found.set, found.place};
  if (const auto known = flat_.find(key); known != flat_.end()) return known->second;
  if (std::ranges::find(open_, key) != open_.end() || open_.size() >= deepest_nesting) {
    problems.add(reference.where, "the set '" + to_string(found.set->name) + "' contains itself",
                 "sets must not contain one another in a circle", "remove one");
    return none;
  }
  open_.push_back(key);
  std::vector<Index> members;
  for (const auto& piece : found.set->pieces) {
    int index = found.place;
    if (!piece.instance.empty()) {
      index = place_named(piece.instance);
      if (index < 0) {
        problems.add(reference.where, "the set '" + to_string(found.set->name) + "' refers to the unknown instance '" +
                                          to_string(piece.instance) + "'");
        continue;
      }
    }
    append(sets, piece, index, members);
  }
  open_.pop_back();
  std::vector<bool> seen(sets == &Scope::node_sets ? mesh.node_ids.size() : elements.size(), false);
  std::erase_if(members, [&](Index member) {
    const bool again = seen[static_cast<std::size_t>(member)];
    seen[static_cast<std::size_t>(member)] = true;
    return again;
  });
  return flat_.emplace(key, std::move(members)).first->second;
}

// A piece holds numbers, ranges (GENERATE), names of further sets, and for a node set the elements whose nodes it
// takes (*NSET, ELSET=). Numbers without a node or element are left out with a note.
void PlacedDeck::append(Sets sets, const RawSet::Piece& piece, int index, std::vector<Index>& members) {
  const bool of_nodes = sets == &Scope::node_sets;
  const auto& positions = index_of(sets, index);
  for (const auto label : piece.labels) {
    if (const auto position = positions.find(label); position >= 0)
      members.push_back(position);
    else
      notes.add(problems.location(piece.where),
                std::string(of_nodes ? "nodes" : "elements") + " of sets that are not nodes or elements of the deck",
                "they are left out of the sets", DeckNoteKind::unused);
  }
  for (const auto& range : piece.ranges) append_range(sets, range, index, members);
  for (const auto& name : piece.names) {
    const auto inner = list(sets, name, index);
    members.insert(members.end(), inner.begin(), inner.end());
  }
  if (piece.of_elements) append_nodes_of(*piece.of_elements, index, members);
}

/// Numbers of a range that exist, by stepping through the range or through what exists, whichever is less.
void PlacedDeck::append_range(Sets sets, const RawSet::Range& range, int index, std::vector<Index>& members) {
  const bool of_nodes = sets == &Scope::node_sets;
  const auto& positions = index_of(sets, index);
  const std::size_t existing = of_nodes ? mesh.node_ids.size() : elements.size();
  if (static_cast<std::uint64_t>((range.last - range.first) / range.step) <= 4 * existing + 1000) {
    for (std::int64_t label = range.first; label <= range.last; label += range.step)
      if (const auto position = positions.find(label); position >= 0) members.push_back(position);
    return;
  }
  for (const Scope* scope : place(index).scopes) {
    const auto take = [&](std::int64_t label) {
      if (label >= range.first && label <= range.last && (label - range.first) % range.step == 0)
        if (const auto position = positions.find(label); position >= 0) members.push_back(position);
    };
    if (of_nodes)
      for (const auto label : scope->nodes.labels) take(label);
    else
      for (const auto& element : scope->elements) take(element.label);
  }
}

// The extra node of an element, such as the orientation node of a beam, is not part of it.
void PlacedDeck::append_nodes_of(const SetReference& element_set, int index, std::vector<Index>& members) {
  std::vector<Index> nodes;
  for (const Index element : element_list(element_set, index)) {
    const auto& placed = elements[static_cast<std::size_t>(element)];
    if (!nodes_of(placed, nodes)) continue;
    if (placed.raw->extra_node >= 0) nodes.pop_back();
    members.insert(members.end(), nodes.begin(), nodes.end());
  }
}

// A thousand names are enough for a suggestion in a message.
std::vector<std::string> PlacedDeck::known_names(Sets sets) const {
  std::vector<std::string> names;
  for (const auto& place : places_)
    for (const Scope* scope : place.scopes)
      for (const auto& [key, set] : scope->*sets)
        if (names.size() < 1000) names.push_back(place.full_name(set.name));
  return names;
}

void PlacedDeck::store_sets() {
  for (int index = 0; index < place_count(); ++index)
    for (const Scope* scope : place(index).scopes) {
      for (const auto& [key, set] : scope->node_sets)
        if (!set.internal)
          mesh.node_sets[place(index).full_name(set.name)] =
              flattened(&Scope::node_sets, {&set, index}, {set.name, {}});
      for (const auto& [key, set] : scope->element_sets)
        if (!set.internal)
          mesh.element_sets[place(index).full_name(set.name)] =
              cells_of(flattened(&Scope::element_sets, {&set, index}, {set.name, {}}));
    }
}

/// Springs, masses and elements without a section are no cells.
std::vector<Index> PlacedDeck::cells_of(const std::vector<Index>& positions) const {
  std::vector<Index> cells;
  for (const Index position : positions)
    if (const Index cell = elements[static_cast<std::size_t>(position)].cell; cell >= 0) cells.push_back(cell);
  return cells;
}

}  // namespace kalfem::abaqus
