// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <vector>

#include "kalfem/casefile/description.hpp"
#include "kalfem/formats/deck.hpp"

namespace kalfem {

/// The decks of a case's finite-element substructures. A file that several of them name is parsed once for each set of
/// options: substructures that stand elsewhere are copies of it.
class DeckFiles {
public:
  explicit DeckFiles(const description::Case& given);

  /// What read_deck() returns; throws what it throws.
  [[nodiscard]] Deck read(const std::filesystem::path& file, const DeckOptions& options);

private:
  struct Parsed {
    std::filesystem::path file;
    DeckOptions options;
    Deck deck;
  };

  std::map<std::filesystem::path, int> substructures_;  ///< how many name a file
  std::vector<Parsed> parsed_;                          ///< of the files that more than one names
};

}  // namespace kalfem
