// SPDX-License-Identifier: Apache-2.0
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
    issues.add(note.where, note_subject(note) + " is missing", note.consequence,
               "correct the deck, or accept this in the case: accept_missing: [" + note.what + "]");
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
  if (is_abaqus && options.subcase)
    throw InvalidInput("SUBCASE " + std::to_string(*options.subcase) + " of " + file.string(),
                       "decks of Abaqus and CalculiX have steps, not subcases", "remove `subcase`");
  return is_abaqus ? read_abaqus(file, options) : read_nastran(file, options);
}

}  // namespace kalfem
