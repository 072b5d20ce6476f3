// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/deck_files.hpp"

#include <algorithm>

#include "kalfem/casefile/finite_element_description.hpp"

namespace kalfem {

DeckFiles::DeckFiles(const description::Case& given) {
  for (const auto& [name, substructure] : given.substructures)
    if (const auto& elements = substructure.finite_elements)
      if (const auto* deck = std::get_if<description::DeckFile>(&elements->source)) ++substructures_[deck->file.value];
}

Deck DeckFiles::read(const std::filesystem::path& file, const DeckOptions& options) {
  const auto same = [&](const Parsed& each) {
    return each.file == file && each.options.format == options.format &&
           each.options.temperature == options.temperature && each.options.subcase == options.subcase &&
           each.options.load_cases == options.load_cases;
  };
  if (const auto found = std::ranges::find_if(parsed_, same); found != parsed_.end()) return found->deck;
  Deck deck = read_deck(file, options);
  if (substructures_[file] > 1) parsed_.push_back({file, options, deck});
  return deck;
}

}  // namespace kalfem
