// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/updating/updated_decks.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "kalfem/base/atomic_file.hpp"

namespace kalfem {
namespace {

std::filesystem::path place_of(const UpdatedDecks& decks, const SubstructureDeck& deck) {
  return decks.folder / deck.substructure;
}

std::string quoted(std::string text) {
  for (auto at = text.find('"'); at != std::string::npos; at = text.find('"', at + 2)) text.insert(at, "\"");
  return '"' + text + '"';
}

}  // namespace

void write_updated_decks(const std::filesystem::path& folder, const UpdatedDecks& decks) {
  if (decks.decks.empty()) return;
  std::string csv = "substructure,parameter,file,line,card,field,before,after,remark\n";
  for (const auto& each : decks.decks) {
    if (!each.deck.texts.empty()) write_deck(each.deck, folder / place_of(decks, each));
    for (const auto& change : each.deck.changes)
      csv += fmt::format("{},{},{},{},{},{},{},{},{}\n", quoted(each.substructure), quoted(change.parameter),
                         quoted(change.where.file), change.where.line, quoted(change.card), quoted(change.field),
                         quoted(change.before), quoted(change.after), quoted(change.remark));
    for (const auto& left : each.deck.unwritten)
      csv += fmt::format("{},{},,,,,,,{}\n", quoted(each.substructure), quoted(left.parameter),
                         quoted("not written: " + left.why + "; " + left.fix));
  }
  std::filesystem::create_directories(folder / decks.folder);
  write_file_atomically(folder / decks.folder / "changes.csv", csv);
}

nlohmann::ordered_json updated_decks_summary(const UpdatedDecks& decks) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const auto& each : decks.decks) {
    nlohmann::ordered_json entry = {{"substructure", each.substructure}, {"file", nullptr}};
    if (!each.deck.texts.empty()) entry["file"] = (place_of(decks, each) / each.deck.file).string();
    entry["changes"] = nlohmann::ordered_json::array();
    for (const auto& change : each.deck.changes)
      entry["changes"].push_back({{"parameter", change.parameter},
                                  {"file", change.where.file},
                                  {"line", change.where.line},
                                  {"card", change.card},
                                  {"field", change.field},
                                  {"before", change.before},
                                  {"after", change.after},
                                  {"remark", change.remark}});
    entry["unwritten"] = nlohmann::ordered_json::array();
    for (const auto& left : each.deck.unwritten)
      entry["unwritten"].push_back({{"parameter", left.parameter}, {"why", left.why}, {"fix", left.fix}});
    if (!each.failure.empty()) entry["failure"] = each.failure;
    list.push_back(std::move(entry));
  }
  return list;
}

Table updated_decks_table(const UpdatedDecks& decks) {
  Table table{.title = "Changed fields of the decks",
              .columns = {"parameter", "card", "field", "line", "before", "after", "remark"},
              .caption = "The decks with these fields stand in " + decks.folder.string() +
                         "; everything else in them is as it was."};
  for (const auto& each : decks.decks)
    for (const auto& change : each.deck.changes)
      table.rows.push_back({change.parameter, change.card, change.field, std::to_string(change.where.line),
                            change.before, change.after, change.remark});
  return table;
}

std::string updated_decks_words(const UpdatedDecks& decks) {
  std::string text;
  for (const auto& each : decks.decks) {
    if (!each.deck.texts.empty())
      text += fmt::format("Updated deck: {} ({} changed field{})\n", (place_of(decks, each) / each.deck.file).string(),
                          each.deck.changes.size(), each.deck.changes.size() == 1 ? "" : "s");
    if (!each.failure.empty())
      text += fmt::format("the deck of '{}' cannot be read again: {}\n", each.substructure, each.failure);
    for (const auto& left : each.deck.unwritten)
      text += fmt::format("  the deck does not state {}: {}; {}\n", left.parameter, left.why, left.fix);
  }
  return text;
}

}  // namespace kalfem
