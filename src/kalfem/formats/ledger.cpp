// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/ledger.hpp"

namespace kalfem {

const char* to_string(DeckNoteKind kind) {
  switch (kind) {
    case DeckNoteKind::missing:
      return "error";
    case DeckNoteKind::changed:
    case DeckNoteKind::doubtful:
      return "warning";
    case DeckNoteKind::unused:
      break;
  }
  return "not used";
}

std::string note_subject(const DeckNote& note) {
  return note.count > 1 ? note.what + " (" + std::to_string(note.count) + " times)" : note.what;
}

// The same note for many cards is kept once with a count, so that a long deck gives a short list.
void DeckNotes::add(const SourceLocation& where, const std::string& what, const std::string& consequence,
                    DeckNoteKind kind, std::size_t count) {
  const auto [place, is_new] = index_.try_emplace(what + '\n' + consequence, notes_.size());
  if (is_new)
    notes_.push_back({where, what, consequence, count, kind});
  else
    notes_[place->second].count += count;
}

const char* to_string(FieldFate fate) {
  switch (fate) {
    case FieldFate::used:
      return "used";
    case FieldFate::told:
      return "told";
    case FieldFate::refused:
      break;
  }
  return "refused";
}

void Ledger::enter(const SourceLocation& where, std::string_view card, std::string_view field, FieldFate fate,
                   std::size_t count) {
  std::string key(card);
  key.append("\n").append(field).append("\n").append(to_string(fate));
  const auto [place, is_new] = index_.try_emplace(std::move(key), entries_.size());
  if (is_new)
    entries_.push_back({std::string(card), std::string(field), fate, count, where});
  else
    entries_[place->second].count += count;
}

}  // namespace kalfem
