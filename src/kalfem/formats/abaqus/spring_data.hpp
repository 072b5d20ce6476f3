// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "kalfem/formats/abaqus/placed_deck.hpp"
#include "kalfem/formats/abaqus/temperatures.hpp"

namespace kalfem::abaqus {

inline bool is_spring(Family family) {
  return family == Family::ground_spring || family == Family::spring || family == Family::axial_spring;
}
inline bool is_dashpot(Family family) {
  return family == Family::ground_dashpot || family == Family::dashpot || family == Family::axial_dashpot;
}
inline bool is_axial(Family family) { return family == Family::axial_spring || family == Family::axial_dashpot; }
inline bool is_grounded(Family family) { return family == Family::ground_spring || family == Family::ground_dashpot; }

/// What *SPRING or *DASHPOT says: directions of its ends and its value.
struct SpringData {
  std::array<int, 2> directions{};
  double value = 0.0;
};

/// Reads the lines of *SPRING or *DASHPOT for elements of a family: directions of the ends, blank for axial ones (decks
/// leave this line out); then rows of a value, a frequency and a temperature, or with NONLINEAR of a force, a
/// deflection and a temperature, of which the slope at rest counts. Values by temperature are interpolated. Nothing,
/// and a problem, for values by frequency or field variables, complex ones, and values by temperature where no
/// temperature is known.
std::optional<SpringData> spring_data(PlacedDeck& deck, const Block& block, Family family,
                                      MaterialTemperature& temperature);

}  // namespace kalfem::abaqus
