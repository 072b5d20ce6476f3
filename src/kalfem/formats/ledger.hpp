// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

/// How much a note matters for the model.
enum class DeckNoteKind {
  unused,    ///< loads, output, other analyses: the model is complete without it
  changed,   ///< the model that is read is another one than the deck describes: a warning of every run
  doubtful,  ///< the model may be another one than the deck means: a warning of every run
  missing    ///< stiffness, mass or a connection that the model lacks: refused unless the user accepts it
};

/// "error", "warning" or "not used", as a person reads it.
const char* to_string(DeckNoteKind kind);

/// Something that a deck holds and the reader does not use as it stands, with what that means for the result.
struct DeckNote {
  SourceLocation where;  ///< its first place
  std::string what;      ///< "*FRICTION", "PLOAD4", "field 12 of CQUAD4"
  std::string consequence;
  std::size_t count = 1;  ///< how often it stands in the deck
  DeckNoteKind kind = DeckNoteKind::unused;
};

/// What the note is about, with its number where it stands several times: "PLOAD4 (12 times)".
std::string note_subject(const DeckNote& note);

/// Notes by kind: the first place is kept, further ones are counted.
class DeckNotes {
public:
  void add(const SourceLocation& where, const std::string& what, const std::string& consequence, DeckNoteKind kind,
           std::size_t count = 1);
  [[nodiscard]] std::vector<DeckNote> take() { return std::move(notes_); }

private:
  std::vector<DeckNote> notes_;
  std::unordered_map<std::string, std::size_t> index_;  ///< by what and consequence
};

/// The end of a field that stands in a file.
enum class FieldFate {
  used,    ///< the model, or a load case where these are read, depends on it
  told,    ///< without effect on the model; a note says so
  refused  ///< a problem names it
};

/// "used", "told" or "refused".
const char* to_string(FieldFate fate);

/// One field of one kind of card, keyword line or data line, over a whole file.
struct LedgerEntry {
  std::string card;   ///< "CQUAD4", "*SPRING"
  std::string field;  ///< "field 12", "line 2, field 3", "parameter OP"
  FieldFate fate = FieldFate::used;
  std::size_t count = 1;  ///< how often it is present in the file
  SourceLocation where;   ///< its first place
};

/// What became of every field that is present in a file: each ends as used, told or refused.
class Ledger {
public:
  void enter(const SourceLocation& where, std::string_view card, std::string_view field, FieldFate fate,
             std::size_t count = 1);
  /// In the order of the first entries.
  [[nodiscard]] std::vector<LedgerEntry> take() { return std::move(entries_); }

private:
  std::vector<LedgerEntry> entries_;
  std::unordered_map<std::string, std::size_t> index_;  ///< by card, field and fate
};

}  // namespace kalfem
