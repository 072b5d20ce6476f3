#include "kalfem/formats/deck.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <set>

#include "kalfem/base/text.hpp"
#include "kalfem/formats/abaqus.hpp"
#include "kalfem/formats/nastran.hpp"

namespace kalfem {
namespace {

/// "*Contact Pair" and "CONTACTPAIR" are one name.
std::string plain_name(const std::string& name) {
  std::string plain;
  for (const char c : name)
    if (c != ' ' && c != '\t' && c != '*') plain += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return plain;
}

}  // namespace

const char* to_string(DeckNoteKind kind) {
  switch (kind) {
    case DeckNoteKind::missing:
      return "error";
    case DeckNoteKind::doubtful:
      return "warning";
    case DeckNoteKind::unused:
      break;
  }
  return "not used";
}

// The same note for many cards is kept once with a count, so that a long deck gives a short list.
void DeckNotes::add(const SourceLocation& where, const std::string& what, const std::string& consequence,
                    DeckNoteKind kind) {
  const auto [place, is_new] = index_.try_emplace(what + '\n' + consequence, notes_.size());
  if (is_new)
    notes_.push_back({where, what, consequence, 1, kind});
  else
    ++notes_[place->second].count;
}

std::vector<std::string> accept_missing(std::vector<DeckNote>& notes, const std::vector<std::string>& accepted,
                                        IssueList& issues) {
  std::set<std::string> met;
  for (auto& note : notes) {
    if (note.kind != DeckNoteKind::missing) continue;
    const auto same_name = [&](const std::string& name) { return plain_name(name) == plain_name(note.what); };
    if (const auto found = std::ranges::find_if(accepted, same_name); found != accepted.end()) {
      met.insert(plain_name(note.what));
      note.kind = DeckNoteKind::doubtful;
      continue;
    }
    issues.add(note.where,
               note.what + (note.count > 1 ? " (" + std::to_string(note.count) + " times)" : "") + " is missing",
               note.consequence, "correct the deck, or accept this in the case: accept_missing: [" + note.what + "]");
  }
  std::vector<std::string> idle;
  std::ranges::copy_if(accepted, std::back_inserter(idle),
                       [&](const std::string& name) { return !met.contains(plain_name(name)); });
  return idle;
}

namespace {

std::string ending_of(const std::filesystem::path& file) { return lower_case(file.extension().string()); }

}  // namespace

bool is_deck(const std::filesystem::path& file) {
  static constexpr std::array endings = {".inp", ".bdf", ".dat", ".nas", ".blk"};
  return std::ranges::find(endings, ending_of(file)) != endings.end();
}

Deck read_deck(const std::filesystem::path& file, const DeckOptions& options) {
  const bool is_inp = ending_of(file) == ".inp";
  const bool is_abaqus = options.format == DeckFormat::abaqus || (options.format == DeckFormat::automatic && is_inp);
  return is_abaqus ? read_abaqus(file, options) : read_nastran(file, options);
}

}  // namespace kalfem
