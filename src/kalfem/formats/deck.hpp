#pragma once

#include <cstddef>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "kalfem/model/finite_element_model.hpp"

namespace kalfem {

/// Something that a deck holds and the reader does not use as it stands, with what that means for the result.
struct DeckNote {
  SourceLocation where;  ///< its first place
  std::string what;      ///< "*FRICTION", "PLOAD4", "field 12 of CQUAD4"
  std::string consequence;
  std::size_t count = 1;  ///< how often it stands in the deck
};

/// A model out of another code's input file, in the file's own units, with what was left out of it.
struct Deck {
  FiniteElementModel model;
  std::vector<DeckNote> notes;  ///< in the order of their first places
};

/// Notes by kind: the first place is kept, further ones are counted.
class DeckNotes {
public:
  void add(const SourceLocation& where, const std::string& what, const std::string& consequence);
  [[nodiscard]] std::vector<DeckNote> take() { return std::move(notes_); }

private:
  std::vector<DeckNote> notes_;
  std::unordered_map<std::string, std::size_t> index_;  ///< by what and consequence
};

}  // namespace kalfem
