#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/formats/abaqus/placed_deck.hpp"

namespace kalfem::abaqus {

/// The one temperature at which the materials of a deck are taken: that of the user, otherwise the initial temperature
/// of the deck, which is 0 at nodes without one.
class MaterialTemperature {
public:
  MaterialTemperature(const RawDeck& raw, PlacedDeck& deck) : stated_(raw.temperature), deck_(deck) {}

  /// Asked for by a keyword that gives values at several temperatures. Initial temperatures that differ between nodes
  /// are a problem; a deck without any gets a note.
  double value(const Keyword& keyword);
  [[nodiscard]] bool is_used() const { return is_used_; }

private:
  double initial(const Keyword& keyword);

  std::optional<double> stated_;
  PlacedDeck& deck_;
  bool is_used_ = false;
};

/// The constants of a keyword such as *ELASTIC at the temperature. A row has `count` constants and then its
/// temperature, eight numbers to a line; fewer than `count` but at least `least` are a row too, with 0 for the others.
/// Linear between the rows' temperatures, constant beyond the first and the last, with a note. Empty, and a problem,
/// where a row is too short.
std::vector<double> constants_at(MaterialTemperature& temperature, const Block& block, std::size_t least,
                                 std::size_t count, PlacedDeck& deck);

}  // namespace kalfem::abaqus
