// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/rewriting/deck_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <set>
#include <tuple>

#include "kalfem/formats/nastran/card_stream.hpp"
#include "kalfem/formats/nastran/case_control.hpp"
#include "kalfem/formats/rewriting/nastran_line.hpp"
#include "kalfem/formats/tables/text_table.hpp"

namespace kalfem::rewriting {
namespace {

using nastran::Card;
using nastran::Id;

/// A card whose fields may change, with their places in the texts.
struct KeptCard {
  std::string name;
  nastran::Place place;
  struct Field {
    std::string text;
    std::optional<std::pair<std::int32_t, std::size_t>> at;  ///< file and offset; nothing of images and behind tabs
  };
  std::vector<Field> fields;

  [[nodiscard]] const std::string& text(std::size_t i) const {
    static const std::string none;
    return i >= 1 && i <= fields.size() ? fields[i - 1].text : none;
  }
  [[nodiscard]] std::optional<Id> id(std::size_t i = 1) const {
    const auto number = nastran::parse_integer(text(i));
    return number ? std::optional(static_cast<Id>(*number)) : std::nullopt;
  }
};

/// Properties and what else states numbers of a model.
bool is_kept(const std::string& name) {
  static const std::set<std::string, std::less<>> others = {"CONROD", "CONM2", "CBUSH", "CBUSH1D"};
  return name.starts_with("MAT") || name.starts_with("CELAS") || others.contains(name) ||
         (name.starts_with('P') && name != "PARAM" && !name.starts_with("PLOAD"));
}

/// Fields in which a card names a material.
std::vector<std::size_t> material_references(const KeptCard& card) {
  if (card.name == "PSHELL") return {2, 4, 6, 11};
  if (card.name == "CONROD") return {4};
  const bool is_global = card.name == "PCOMPG";
  if (card.name == "PCOMP" || is_global) {
    std::vector<std::size_t> fields;
    for (std::size_t i = is_global ? 10 : 9; i <= card.fields.size(); i += is_global ? 8 : 4) fields.push_back(i);
    return fields;
  }
  static const std::set<std::string, std::less<>> second = {"PSOLID", "PBAR", "PBARL", "PBEAM",
                                                            "PBEAML", "PROD", "PTUBE", "PSHEAR"};
  return second.contains(card.name) ? std::vector<std::size_t>{2} : std::vector<std::size_t>{};
}

/// The number behind a prefix: 12 of "pshell12" and of "pshell12.2".
std::optional<Id> number_behind(const std::string& name, std::string_view prefix) {
  if (!name.starts_with(prefix)) return std::nullopt;
  const auto digits = name.substr(prefix.size(), name.find('.', prefix.size()) - prefix.size());
  if (digits.empty() || !std::ranges::all_of(digits, [](char c) { return c >= '0' && c <= '9'; })) return std::nullopt;
  return static_cast<Id>(nastran::parse_integer(digits).value_or(0));
}

constexpr std::size_t none = static_cast<std::size_t>(-1);  ///< position of a card that is not there

std::string field_title(std::size_t i) { return nastran::place_on_card(i); }

class NastranText final : public DeckText {
public:
  NastranText(const std::string& content, const std::string& source, const NastranIncludes& includes)
      : lines_(content, source, includes, files_) {
    nastran::CardStream stream(files_, [this](const Card& card) { keep(card); });
    bool in_bulk = !nastran::has_case_control(lines_.main_text());
    while (const auto line = lines_.next()) {
      const auto word = upper_case(trimmed(line->text).substr(0, 7));
      if (word == "ENDDATA") break;
      if (word.starts_with("BEGIN"))
        in_bulk = nastran::begins_bulk(line->text);
      else if (in_bulk)
        stream.line(*line);
    }
    stream.finish();
  }

  [[nodiscard]] std::vector<FieldPlace> fields_of(const std::string& parameter) const override;
  [[nodiscard]] std::vector<FieldPlace> material_fields(const std::string& material,
                                                        const std::string& quantity) const override;
  [[nodiscard]] std::vector<MaterialUse> uses_of(const std::string& material,
                                                 const FiniteElementModel& model) const override;
  [[nodiscard]] double number(const FieldPlace& place) const override;
  void set(const FieldPlace& place, double value, const std::string& cause) override {
    edits_.push_back({place, value, cause, ""});
  }
  void split(const std::string& material, const Numbers& numbers, const std::vector<MaterialUse>& users,
             const std::string& cause) override;
  [[nodiscard]] Texts apply(std::vector<DeckFieldChange>& changes) override;

private:
  struct Edit {
    FieldPlace place;
    std::variant<double, std::string> content;
    std::string cause, remark;
  };

  void keep(const Card& card);
  [[nodiscard]] std::size_t find(const std::string& name, Id id, std::size_t field = 1) const;
  [[nodiscard]] std::vector<FieldPlace> stiffness_fields(const std::string& spring) const;
  [[nodiscard]] FieldPlace scalar_spring(Id id) const;
  [[nodiscard]] FieldPlace bushing(Id id, std::size_t component) const;
  [[nodiscard]] const KeptCard& card(const FieldPlace& place) const { return cards_[place.card]; }
  [[nodiscard]] FieldPlace located(std::size_t card, std::size_t field) const;
  [[nodiscard]] std::vector<std::string> regions_of(const KeptCard& card, const std::string& material,
                                                    const FiniteElementModel& model) const;
  [[nodiscard]] std::size_t end_of_card(const KeptCard& card) const;
  [[nodiscard]] DeckFieldChange change_of(const Edit& edit, const std::string& after) const;

  nastran::DeckFiles files_;
  nastran::DeckLines lines_;
  std::vector<KeptCard> cards_;
  std::map<std::tuple<std::string, std::size_t, Id>, std::size_t> index_;  ///< by name, field and the number in it
  std::vector<Edit> edits_;
  std::map<std::pair<std::int32_t, std::size_t>, std::string> new_cards_;  ///< by file and offset
  std::vector<DeckFieldChange> added_;
  Id last_material_ = 0;
};

void NastranText::keep(const Card& card) {
  if (!is_kept(card.name)) return;
  KeptCard kept{card.name, card.place, {}};
  for (const auto field : card.fields)
    kept.fields.push_back({std::string(field), field.empty() ? std::nullopt : lines_.place_of(field)});
  if (card.name.starts_with("MAT")) last_material_ = std::max(last_material_, kept.id().value_or(0));
  const auto enter = [&](std::size_t field) {
    if (const auto id = kept.id(field)) index_.try_emplace({kept.name, field, *id}, cards_.size());
  };
  enter(1);
  if (kept.name == "PELAS") enter(5);
  cards_.push_back(std::move(kept));
}

std::size_t NastranText::find(const std::string& name, Id id, std::size_t field) const {
  const auto found = index_.find({name, field, id});
  return found == index_.end() ? none : found->second;
}

FieldPlace NastranText::located(std::size_t card, std::size_t field) const {
  if (card == none) throw Unwritable("no card of the deck states it alone", "change the deck by hand");
  const auto& kept = cards_[card];
  const std::string title = kept.name + " " + kept.text(1);
  if (kept.text(field).empty())
    throw Unwritable(field_title(field) + " of " + title + " is blank", "fill it in, and update again");
  if (!kept.fields[field - 1].at)
    throw Unwritable(title + " is the image of another card, or has tabs in its line",
                     "write the card in full, with blanks in the place of tabs");
  return {card, 0, static_cast<int>(field)};
}

std::vector<FieldPlace> NastranText::fields_of(const std::string& parameter) const {
  const auto [name, quantity] = split_name(parameter);
  if (quantity == "thickness")
    if (const auto id = number_behind(name, "pshell")) return {located(find("PSHELL", *id), 3)};
  if (quantity == "mass")
    if (const auto id = number_behind(name, "conm2_")) return {located(find("CONM2", *id), 4)};
  if (quantity == "stiffness") return stiffness_fields(name);
  throw Unwritable("no field of bulk data states it", "change the deck by hand");
}

std::vector<FieldPlace> NastranText::stiffness_fields(const std::string& spring) const {
  if (const auto id = number_behind(spring, "celas")) return {scalar_spring(*id)};
  const auto component = spring.find(".k") == std::string::npos
                             ? std::nullopt
                             : nastran::parse_integer(std::string_view(spring).substr(spring.find(".k") + 2));
  if (const auto id = number_behind(spring, "cbush1d")) {
    const auto element = find("CBUSH1D", *id);
    if (element == none) throw Unwritable("its card is not found", "change the deck by hand");
    return {located(find("PBUSH1D", cards_[element].id(2).value_or(*id)), 2)};
  }
  if (const auto id = number_behind(spring, "cbush"); id && component)
    return {bushing(*id, static_cast<std::size_t>(*component))};
  throw Unwritable("no field of bulk data states this stiffness alone", "change the deck by hand");
}

/// K on CELAS2 and CELAS4, or on the PELAS, of which a card holds two.
FieldPlace NastranText::scalar_spring(Id id) const {
  for (const char* name : {"CELAS2", "CELAS4"})
    if (const auto element = find(name, id); element != none) return located(element, 2);
  for (const char* name : {"CELAS1", "CELAS3"}) {
    const auto element = find(name, id);
    if (element == none) continue;
    const Id property = cards_[element].id(2).value_or(id);
    for (const std::size_t field : {1u, 5u})
      if (const auto card = find("PELAS", property, field); card != none) return located(card, field + 1);
  }
  throw Unwritable("its card is not found", "change the deck by hand");
}

/// The field behind the K of PBUSH, which begins one of its groups of eight.
FieldPlace NastranText::bushing(Id id, std::size_t component) const {
  const auto element = find("CBUSH", id);
  const auto card = element == none ? none : find("PBUSH", cards_[element].id(2).value_or(id));
  if (card != none)
    for (std::size_t flag = 2; flag <= cards_[card].fields.size(); flag += 8)
      if (upper_case(cards_[card].text(flag)) == "K") return located(card, flag + component);
  throw Unwritable("its PBUSH is not found", "change the deck by hand");
}

// Of E, G and NU two may be given. Both moduli follow, so that Poisson's ratio stays.
std::vector<FieldPlace> NastranText::material_fields(const std::string& material, const std::string& quantity) const {
  const auto id = number_behind(material, "mat");
  const auto card = id ? find("MAT1", *id) : none;
  if (card == none) throw Unwritable("no MAT1 of the deck states it", "change the deck by hand");
  const std::vector<std::size_t> fields =
      quantity == "density" ? std::vector<std::size_t>{5} : std::vector<std::size_t>{2, 3};
  if (const auto table = find("MATT1", *id); table != none)
    for (const auto field : fields)
      if (!cards_[table].text(field).empty())
        throw Unwritable("it depends on temperature by MATT1 " + cards_[table].text(1),
                         "multiply the values of its table by hand");
  std::vector<FieldPlace> places;
  for (const auto field : fields)
    if (!cards_[card].text(field).empty()) places.push_back(located(card, field));
  if (places.empty()) return {located(card, fields.front())};
  return places;
}

// Regions bear the name of their card: "pshell3", "pshell3.2", "pbarl7"; rods of PTUBE have that of PROD.
std::vector<std::string> NastranText::regions_of(const KeptCard& card, const std::string& material,
                                                 const FiniteElementModel& model) const {
  std::string kind = lower_case(card.name == "PTUBE" ? "PROD" : card.name == "PCOMPG" ? "PCOMP" : card.name);
  std::vector<std::string> names;
  for (const auto& [region, property] : model.properties) {
    const bool is_own = card.name == "CONROD" ? region.starts_with("conrod") && material_of(property) == material
                                              : number_behind(region, kind) == card.id();
    if (is_own) names.push_back(region);
  }
  return names;
}

std::vector<MaterialUse> NastranText::uses_of(const std::string& material, const FiniteElementModel& model) const {
  std::vector<MaterialUse> uses;
  const auto id = number_behind(material, "mat");
  for (std::size_t i = 0; i < cards_.size(); ++i) {
    MaterialUse use;
    for (const auto field : material_references(cards_[i]))
      if (id && cards_[i].id(field) == id) use.references.push_back({i, 0, static_cast<int>(field)});
    if (use.references.empty()) continue;
    use.regions = regions_of(cards_[i], material, model);
    use.is_fixed = cards_[i].name == "PSHEAR";
    uses.push_back(std::move(use));
  }
  return uses;
}

double NastranText::number(const FieldPlace& place) const {
  const auto& text = card(place).text(static_cast<std::size_t>(place.field));
  const auto value = nastran::parse_real(text);
  if (!value || *value == 0.0)
    throw Unwritable(field_title(static_cast<std::size_t>(place.field)) + " of " + card(place).name + " " +
                         card(place).text(1) + " is '" + text + "'",
                     "a field that is multiplied needs a number other than 0");
  return *value;
}

// The copy is written in large fields, which any field of the card fits.
void NastranText::split(const std::string& material, const Numbers& numbers, const std::vector<MaterialUse>& users,
                        const std::string& cause) {
  const Id old_id = number_behind(material, "mat").value_or(0);
  const auto index = find("MAT1", old_id);
  if (find("MATT1", old_id) != none)
    throw Unwritable("MAT1 " + std::to_string(old_id) + " would have to be split, and MATT1 refers to it",
                     "give what is updated a material of its own");
  for (const auto& user : users)
    for (const auto& reference : user.references)
      static_cast<void>(located(reference.card, static_cast<std::size_t>(reference.field)));
  const auto& original = cards_[index];
  const std::string id = std::to_string(++last_material_);
  std::vector<std::string> fields;
  for (const auto& field : original.fields) fields.push_back(field.text);
  fields.resize((fields.size() + 7) / 8 * 8);
  fields[0] = id;
  const std::string remark = fmt::format("MAT1 {} is split: what is not updated keeps it", old_id);
  const auto where = files_.location(original.place);
  added_.push_back({cause, where, "MAT1 " + id, "new card", "", "copy of MAT1 " + std::to_string(old_id), remark});
  for (const auto& [place, value, own_cause] : numbers) {
    auto& field = fields[static_cast<std::size_t>(place.field) - 1];
    const std::string before = std::exchange(field, nastran_real(value, 16));
    added_.push_back(
        {own_cause, where, "MAT1 " + id, field_title(static_cast<std::size_t>(place.field)), before, field, remark});
  }
  std::string text;
  for (std::size_t i = 0; i < fields.size(); i += 4) {
    text += fmt::format("{:<8}", i == 0 ? "MAT1*" : "*");
    for (std::size_t k = i; k < i + 4; ++k) text += fmt::format("{:<16}", fields[k]);
    text.erase(text.find_last_not_of(' ') + 1);
    text += '\n';
  }
  new_cards_[{original.place.file, end_of_card(original)}] += text;
  for (const auto& user : users)
    for (const auto& reference : user.references) edits_.push_back({reference, id, cause, remark});
}

/// Behind the lines of a card and those that may continue it.
std::size_t NastranText::end_of_card(const KeptCard& card) const {
  std::size_t last = 0;
  for (const auto& field : card.fields)
    if (field.at && field.at->first == card.place.file) last = std::max(last, field.at->second);
  const std::string& text = lines_.text(card.place.file);
  const auto next_line = [&](std::size_t at) { return std::min(text.find('\n', at), text.size() - 1) + 1; };
  std::size_t end = next_line(last);
  while (end < text.size() && std::string_view("+* ,\t").find(text[end]) != std::string_view::npos)
    end = next_line(end);
  return end;
}

DeckFieldChange NastranText::change_of(const Edit& edit, const std::string& after) const {
  const auto& kept = card(edit.place);
  const auto field = static_cast<std::size_t>(edit.place.field);
  return {edit.cause,
          files_.location(kept.place),
          kept.name + " " + kept.text(1),
          field_title(field),
          kept.text(field),
          after,
          edit.remark};
}

// Edits of one line are made together, as one of them may turn the line into one of large fields.
Texts NastranText::apply(std::vector<DeckFieldChange>& changes) {
  std::map<std::pair<std::int32_t, std::size_t>, std::vector<std::size_t>> of_line;
  for (std::size_t i = 0; i < edits_.size(); ++i) {
    const auto& [file, at] = *card(edits_[i].place).fields[static_cast<std::size_t>(edits_[i].place.field) - 1].at;
    const auto before = at == 0 ? std::string::npos : lines_.text(file).rfind('\n', at - 1);
    of_line[{file, before == std::string::npos ? 0 : before + 1}].push_back(i);
  }
  std::map<std::int32_t, TextEdits> of_file;
  for (const auto& [line, edits] : of_line) {
    const auto& [file, begin] = line;
    const std::string& text = lines_.text(file);
    std::string present = text.substr(begin, std::min(text.find('\n', begin), text.size()) - begin);
    const bool has_return = present.ends_with('\r');
    if (has_return) present.pop_back();
    std::vector<LineEdit> contents;
    for (const auto i : edits) {
      const auto& field = card(edits_[i].place).fields[static_cast<std::size_t>(edits_[i].place.field) - 1];
      contents.push_back({field.at->second - begin, field.text.size(), edits_[i].content});
    }
    auto line_after = rewritten_line(present, contents);
    if (has_return && line_after.became_large) line_after.text.replace(line_after.text.find('\n'), 1, "\r\n");
    of_file[file].replace(begin, present.size(), line_after.text);
    for (std::size_t k = 0; k < edits.size(); ++k) {
      auto change = change_of(edits_[edits[k]], line_after.contents[k]);
      if (line_after.became_large) {
        if (!change.remark.empty()) change.remark += "; ";
        change.remark += "its line has large fields now: 8 columns would round it by more than 2e-6";
      }
      changes.push_back(std::move(change));
    }
  }
  for (auto& [place, text] : new_cards_) {
    const auto& [file, at] = place;
    const std::string& whole = lines_.text(file);
    const bool is_open = at == whole.size() && !whole.ends_with('\n');
    of_file[file].insert(at, (is_open ? "\n" : "") + text);
  }
  changes.insert(changes.end(), added_.begin(), added_.end());
  Texts texts;
  for (const auto& [file, file_edits] : of_file)
    texts[files_.location({file, 0}).file] = file_edits.applied(lines_.text(file));
  return texts;
}

}  // namespace

std::unique_ptr<DeckText> nastran_text(const std::string& content, const std::string& source,
                                       const NastranIncludes& includes) {
  return std::make_unique<NastranText>(content, source, includes);
}

}  // namespace kalfem::rewriting
