// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/formats/abaqus/placed_deck.hpp"

namespace kalfem::abaqus {

/// The one temperature at which the materials of a deck are taken: that of the user, otherwise the temperature of the
/// deck in model_step(), by *INITIAL CONDITIONS and *TEMPERATURE of the steps; it is 0 at nodes without one.
class MaterialTemperature {
public:
  MaterialTemperature(const RawDeck& raw, PlacedDeck& deck) : raw_(raw), stated_(raw.temperature), deck_(deck) {}

  /// Asked for by a keyword that gives values at several temperatures. Temperatures that differ between nodes, or
  /// between the model and a static step, are a problem; a deck without any gets a note.
  double value(const Keyword& keyword);
  /// Whether value() has an answer: the user or the deck states a temperature.
  [[nodiscard]] bool is_known() const;
  [[nodiscard]] bool is_used() const { return is_used_; }

private:
  double of_deck(const Keyword& keyword);
  bool set(const Block& block, int place, double factor, std::vector<double>& temperatures);

  const RawDeck& raw_;
  std::optional<double> stated_;
  PlacedDeck& deck_;
  bool is_used_ = false;
};

/// Constants at one temperature.
struct TemperatureRow {
  std::vector<double> constants;
  double temperature = 0.0;
};

/// Linear between the rows' temperatures, constant beyond the first and the last, with a note; one row is that.
std::vector<double> constants_at(MaterialTemperature& temperature, std::vector<TemperatureRow> rows,
                                 const Keyword& keyword, PlacedDeck& deck);

/// The constants of a keyword such as *ELASTIC at the temperature. A row has `count` constants and then its
/// temperature, eight numbers to a line; fewer than `count` but at least `least` are a row too, with 0 for the others.
/// Linear between the rows' temperatures, constant beyond the first and the last, with a note. Empty, and a problem,
/// where a row is too short.
std::vector<double> constants_at(MaterialTemperature& temperature, const Block& block, std::size_t least,
                                 std::size_t count, PlacedDeck& deck);

}  // namespace kalfem::abaqus
