// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <string_view>

#include "kalfem/formats/abaqus/deck_lines.hpp"
#include "kalfem/formats/abaqus/raw_deck.hpp"

namespace kalfem::abaqus {

/// Reads the keywords of a deck in their order. Names are not looked up yet.
/// Problems are noted; those that leave no sense in what follows throw.
/// `load_cases`: keep the loads of steps too.
RawDeck read_deck(DeckLines& lines, bool load_cases, DeckNotes& notes, Problems& problems);

/// Adds the data of *NODE, *ELEMENT, *NSET and *ELSET to a scope.
class MeshReader {
public:
  MeshReader(RawDeck& deck, DeckLines& lines, Problems& problems) : deck_(deck), lines_(lines), problems_(problems) {}

  void read_system();  ///< *SYSTEM: the axes of the nodes that follow
  void forget_system() { system_ = Eigen::Isometry3d::Identity(); }
  void read_nodes(Scope& scope, const Keyword& keyword);
  void read_elements(Scope& scope, const Keyword& keyword);
  void read_set(Scope& scope, const Keyword& keyword, bool of_nodes);

private:
  void add_extra(const char* card, const char* name, const char* consequence);
  bool read_node(RawNodes& nodes, std::string_view line, const std::string& axes);
  int type_of(const Keyword& keyword);
  void read_element(Scope& scope, std::string_view line, int type);
  std::int64_t node_reference(Scope& scope, std::string_view field);
  void read_generated_piece(RawSet::Piece& piece, std::string_view line);
  void read_listed_piece(RawSet::Piece& piece, std::string_view line);

  RawDeck& deck_;
  DeckLines& lines_;
  Problems& problems_;
  Eigen::Isometry3d system_ = Eigen::Isometry3d::Identity();
};

/// What the reader does with a keyword that has no function of its own in it.
enum class KeywordUse {
  stored,           ///< kept with its data lines, used when the model is put together
  procedure,        ///< what a step computes
  load,             ///< a load of a step: kept where load cases are wanted
  option,           ///< belongs to the stored keyword before it
  material_option,  ///< belongs to the material before it
  silent,           ///< output and comments: nothing is lost
  noted,            ///< no part of the result, for a note
  doubtful,         ///< may change the model, for a note that warns
  changed,          ///< changes the model, for a note that warns
  lacking,          ///< a connection, or not known: the model lacks it, which the user may accept
  missing           ///< nothing that the model could do without: a problem
};

struct KeywordClass {
  KeywordUse use = KeywordUse::noted;
  std::string consequence = {};  ///< for a note, or why the model would be incomplete
};

/// `name` as of Keyword: capitals without blanks.
KeywordClass classify(std::string_view name);

}  // namespace kalfem::abaqus
