// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "kalfem/formats/deck.hpp"
#include "kalfem/model/unit_system.hpp"

namespace kalfem {

/// A number of a finite-element model that its deck shall state anew.
struct DeckValue {
  std::string
      parameter;       ///< of the model: "mat7.youngs_modulus", "pshell3.thickness", "conm2_12.mass", "prod5.stiffness"
  double value = 0.0;  ///< SI
  std::string cause = {};  ///< what asks for it, for the list of changes; empty: the parameter
};

/// A field of a deck that states another value than before, or a card that is new.
struct DeckFieldChange {
  std::string parameter;      ///< what asked for it
  SourceLocation where;       ///< in the deck as it was
  std::string card, field;    ///< "MAT1 7", "line 1, field 3"
  std::string before, after;  ///< as they stand in the file; before is empty where a card is new
  std::string remark = {};    ///< why more than the field changes: a large field, a card that was split
};

/// A value that no field of the deck can state.
struct UnwrittenValue {
  std::string parameter;  ///< what asked for it
  std::string why, fix;
};

/// A deck that states other values, in memory. All that is not listed is as it was, byte for byte.
struct UpdatedDeck {
  std::vector<DeckFieldChange> changes;
  std::vector<UnwrittenValue> unwritten;
  std::filesystem::path file;                          ///< the deck among `texts`
  std::map<std::filesystem::path, std::string> texts;  ///< with the files that it includes, by relative places; empty
                                                       ///< where nothing changes
};

/// The deck with other values of some parameters: of materials, thicknesses, springs and masses, and the factor
/// `stiffness` of a region of beams.
///
/// A field is multiplied by the ratio of the new value to the deck's own one, so that the deck keeps its units. A field
/// of 8 columns whose rounding would exceed 2e-6 makes its line one of large fields; others are right to 1e-9. Where
/// not all that is made of a material changes alike, what changes gets a copy of the material under a free number or
/// name. The result is read again: if it were another model than the one that is meant, all values are unwritten.
///
/// `options`: as for reading the deck; `units`: of the deck. Throws InvalidInput as read_deck() does.
UpdatedDeck updated_deck(const std::filesystem::path& file, const std::vector<DeckValue>& values,
                         const DeckOptions& options = {}, const UnitSystem& units = {});

/// Writes the texts below a folder, which is made; returns the place of the deck. Throws InvalidInput where it cannot.
std::filesystem::path write_deck(const UpdatedDeck& deck, const std::filesystem::path& folder);

}  // namespace kalfem
