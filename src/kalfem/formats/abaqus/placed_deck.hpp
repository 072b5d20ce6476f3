// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "kalfem/formats/abaqus/orientations.hpp"
#include "kalfem/formats/abaqus/raw_deck.hpp"
#include "kalfem/formats/deck.hpp"

namespace kalfem::abaqus {

/// Finds positions by numbers of a deck: a table where the numbers are dense, else a hash table.
class LabelIndex {
public:
  /// Room for so many numbers up to the largest.
  void prepare(std::size_t count, std::int64_t largest) {
    is_table_ = largest >= 0 && static_cast<std::uint64_t>(largest) < 8 * static_cast<std::uint64_t>(count) + 1024;
    if (is_table_)
      table_.assign(static_cast<std::size_t>(largest) + 1, -1);
    else
      map_.reserve(count);
  }
  /// Position of a number, -1 where there is none.
  [[nodiscard]] std::int64_t find(std::int64_t label) const {
    if (is_table_)
      return label >= 0 && static_cast<std::size_t>(label) < table_.size() ? table_[static_cast<std::size_t>(label)]
                                                                           : -1;
    const auto entry = map_.find(label);
    return entry == map_.end() ? -1 : entry->second;
  }
  /// The number must be one that prepare() was told of, and new.
  void add(std::int64_t label, std::int64_t position) {
    if (is_table_)
      table_[static_cast<std::size_t>(label)] = static_cast<std::int32_t>(position);
    else
      map_.emplace(label, position);
  }

private:
  bool is_table_ = false;
  std::vector<std::int32_t> table_;
  std::unordered_map<std::int64_t, std::int64_t> map_;
};

using Eigen::Index;

/// An instance with its part, or the deck beside its instances (the first place, without a name).
struct Place {
  std::string name;
  std::vector<const Scope*> scopes;
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  LabelIndex nodes;            ///< of the mesh, by number in the deck
  LabelIndex elements;         ///< of all elements, by number in the deck
  std::int64_t raised_by = 0;  ///< number in the mesh less number in the deck

  /// "set" of the deck, "instance.set" of an instance.
  [[nodiscard]] std::string full_name(const std::string& own) const { return name.empty() ? own : name + "." + own; }
};

/// An element of the assembly.
struct PlacedElement {
  const RawElement* raw = nullptr;
  const Scope* scope = nullptr;
  int place = 0;
  int section = -1;  ///< position in a list of sections
  Index cell = -1;   ///< of the mesh
};

/// What an element that is no cell, or a nonstructural mass on one, weighs at a node.
struct ElementMass {
  Index element = 0, node = 0;
  double mass = 0.0, volume = 0.0;
  bool by_direction = false;  ///< *MASS, TYPE=ANISOTROPIC
};

/// A keyword with the place whose names it uses.
struct PlacedBlock {
  const Block* block = nullptr;
  int place = 0;
};

/// Nodes and elements of all places in one numbering, and everything that is found by name.
class PlacedDeck {
public:
  /// Places the instances and collects nodes and elements; problems are noted. Everything given must outlive this.
  PlacedDeck(const RawDeck& raw, Mesh& mesh, DeckNotes& notes, Problems& problems);

  Mesh& mesh;  ///< gets the nodes and their numbers
  std::vector<PlacedElement> elements;
  std::vector<ElementMass> element_masses;
  std::vector<std::string> regions_by_nodes;  ///< regions whose thickness is given at their nodes
  std::map<std::string, Where> origins;       ///< see DeckOrigins
  std::map<Index, Eigen::Matrix3d>
      load_axes;                       ///< of nodes whose loads are not along global axes or those of *TRANSFORM
  std::map<Index, Index> local_nodes;  ///< of nodes that load cases move along axes of *TRANSFORM, see add_local_node()

  [[nodiscard]] const Place& place(int index) const { return places_[static_cast<std::size_t>(index)]; }
  [[nodiscard]] int place_count() const { return static_cast<int>(places_.size()); }
  [[nodiscard]] const ElementType& type_of(const PlacedElement& element) const {
    return raw_.types[static_cast<std::size_t>(element.raw->type)].type;
  }
  [[nodiscard]] const std::string& type_name(const PlacedElement& element) const {
    return raw_.types[static_cast<std::size_t>(element.raw->type)].name;
  }
  /// Nodes of an element in the order of the deck, false where one does not exist (a problem). A beam's extra node is
  /// the last one.
  bool nodes_of(const PlacedElement& element, std::vector<Index>& nodes);
  [[nodiscard]] Index position_of(const PlacedElement& element) const { return &element - elements.data(); }
  /// Name for messages and springs: "17", "Wing-1.17".
  [[nodiscard]] std::string element_name(const PlacedElement& element) const;

  /// Every keyword of that name, instance by instance and the deck's own last.
  [[nodiscard]] std::vector<PlacedBlock> blocks(std::string_view keyword) const;
  /// The keyword with NAME=name that is visible at a place; no block where there is none.
  [[nodiscard]] PlacedBlock find_block(std::string_view keyword, const std::string& name, int place) const;

  /// Nodes of a set or one node; a name that is not known is a problem.
  std::vector<Index> node_list(const SetReference& reference, int place);
  /// The same of elements, as positions in `elements`.
  std::vector<Index> element_list(const SetReference& reference, int place);
  /// Whether a name stands for a set of nodes (of elements) there.
  [[nodiscard]] bool is_node_set(const std::string& name, int place) const;
  [[nodiscard]] bool is_element_set(const std::string& name, int place) const;
  /// Spelling of a set as it was defined, with its instance: "Wing-1.Skin".
  [[nodiscard]] std::string spelled_set(const std::string& name, int place, bool of_nodes) const;

  /// Whether *MATRIX ASSEMBLE adds to the model.
  [[nodiscard]] bool has_matrices() const { return !raw_.matrices.empty(); }
  /// Whether the deck was written for Abaqus; otherwise it is taken for one of CalculiX.
  [[nodiscard]] bool of_abaqus() const { return raw_.from_abaqus; }
  /// Copies all sets of nodes and of elements but internal ones to the mesh.
  void store_sets();

  DeckNotes& notes;
  Problems& problems;

private:
  using Sets = std::map<std::string, RawSet> Scope::*;
  struct Found {
    const RawSet* set = nullptr;
    int place = 0;
  };

  void make_places();
  Eigen::Isometry3d motion_of(const RawInstance& instance);
  void number_places();
  void add_nodes(Place& place);
  void add_elements(int place);
  int place_named(std::string_view name) const;
  Found find_set(Sets sets, const std::string& name, int place) const;
  std::vector<Index> list(Sets sets, const SetReference& reference, int place);
  const std::vector<Index>& flattened(Sets sets, const Found& found, const SetReference& reference);
  void append(Sets sets, const RawSet::Piece& piece, int place, std::vector<Index>& members);
  void append_range(Sets sets, const RawSet::Range& range, int place, std::vector<Index>& members);
  [[nodiscard]] std::vector<Index> cells_of(const std::vector<Index>& positions) const;
  void append_nodes_of(const SetReference& element_set, int place, std::vector<Index>& members);
  std::vector<std::string> known_names(Sets sets) const;
  [[nodiscard]] const LabelIndex& index_of(Sets sets, int place) const {
    return sets == &Scope::node_sets ? places_[static_cast<std::size_t>(place)].nodes
                                     : places_[static_cast<std::size_t>(place)].elements;
  }

  const RawDeck& raw_;
  std::vector<Place> places_;
  std::map<std::pair<const RawSet*, int>, std::vector<Index>> flat_;
  std::vector<std::pair<const RawSet*, int>> open_;  ///< sets that are being flattened
};

}  // namespace kalfem::abaqus
