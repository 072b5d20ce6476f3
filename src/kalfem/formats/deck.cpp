#include "kalfem/formats/deck.hpp"

namespace kalfem {

void DeckNotes::add(const SourceLocation& where, const std::string& what, const std::string& consequence) {
  const auto [place, is_new] = index_.try_emplace(what + '\n' + consequence, notes_.size());
  if (is_new)
    notes_.push_back({where, what, consequence, 1});
  else
    ++notes_[place->second].count;
}

}  // namespace kalfem
