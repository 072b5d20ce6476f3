// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/rewriting/deck_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <set>
#include <variant>

#include "kalfem/formats/abaqus/deck_reader.hpp"
#include "kalfem/formats/abaqus/raw_deck.hpp"

namespace kalfem::rewriting {
namespace {

using abaqus::Keyword;

/// A keyword with its data lines, and the material that it belongs to.
struct KeptBlock {
  Keyword keyword;
  SourceLocation where;
  std::vector<abaqus::DataLine> lines;
  std::string material;  ///< in capitals, of *ELASTIC and *DENSITY
};

constexpr int keyword_line = -1;
/// "Fields" of a keyword line: the values of these parameters.
enum ParameterField { material_parameter = 0, offset_parameter = 1 };
const char* parameter_name(int field) { return field == material_parameter ? "MATERIAL" : "OFFSET"; }

/// Twelve digits, which fit the 20 columns of CalculiX.
std::string abaqus_real(double value) { return fmt::format("{:.12g}", value); }

std::string field_title(const FieldPlace& place) {
  return place.line == keyword_line ? std::string("parameter ") + parameter_name(place.field)
                                    : fmt::format("line {}, field {}", place.line + 1, place.field + 1);
}

class AbaqusText final : public DeckText {
public:
  AbaqusText(const std::string& content, const std::string& source, const DeckLoader& loader,
             const DeckOrigins& origins)
      : origins_(origins) {
    texts_[source] = content;
    const DeckLoader keeping = [&](const std::filesystem::path& path) { return texts_[path.string()] = loader(path); };
    abaqus::Problems problems;
    abaqus::DeckLines lines(content, source, keeping, problems);
    std::string material;
    for (Keyword keyword; lines.next_keyword(keyword);) keep(keyword, lines, problems, material);
  }

  [[nodiscard]] std::vector<FieldPlace> fields_of(const std::string& parameter) const override;
  [[nodiscard]] std::vector<FieldPlace> material_fields(const std::string& material,
                                                        const std::string& quantity) const override;
  [[nodiscard]] std::vector<MaterialUse> uses_of(const std::string& material,
                                                 const FiniteElementModel& model) const override;
  [[nodiscard]] double number(const FieldPlace& place) const override;
  void set(const FieldPlace& place, double value, const std::string& cause) override {
    edits_.push_back({place, abaqus_real(value), cause, ""});
  }
  void split(const std::string& material, const Numbers& numbers, const std::vector<MaterialUse>& users,
             const std::string& cause) override;
  [[nodiscard]] Texts apply(std::vector<DeckFieldChange>& changes) override;

private:
  struct Edit {
    FieldPlace place;
    std::string content, cause, remark;
  };
  /// A part of a text.
  struct Span {
    std::string file;
    std::size_t at = 0, length = 0;
  };

  void keep(const Keyword& keyword, abaqus::DeckLines& lines, const abaqus::Problems& problems, std::string& material);
  [[nodiscard]] std::size_t block_at(const std::string& name) const;
  [[nodiscard]] std::vector<FieldPlace> thickness_fields(std::size_t block) const;
  [[nodiscard]] std::vector<FieldPlace> spring_fields(std::size_t block) const;
  [[nodiscard]] std::size_t line_begin(const SourceLocation& where) const;
  [[nodiscard]] Span span_of(const FieldPlace& place) const;
  [[nodiscard]] Span span_of_material(const std::string& material) const;
  [[nodiscard]] std::string content_of(const FieldPlace& place) const;
  [[nodiscard]] DeckFieldChange change_of(const Edit& edit) const;

  const DeckOrigins& origins_;
  Texts texts_;
  std::vector<KeptBlock> blocks_;
  std::vector<SourceLocation> keywords_;  ///< that do not belong to a material: ends of materials
  std::vector<Edit> edits_;
  std::map<std::string, TextEdits> inserted_;
  std::vector<DeckFieldChange> added_;
  std::set<std::string> materials_;  ///< names in capitals
};

/// Keywords that may stand below *MATERIAL: those of one class with one of these.
bool is_of_material(const std::string& name) {
  const auto own = abaqus::classify(name);
  constexpr std::array like{"ELASTIC", "PLASTIC", "EXPANSION", "DAMPING"};
  return name == "DEPVAR" || std::ranges::any_of(like, [&](const char* other) {
           const auto known = abaqus::classify(other);
           return own.use == known.use && own.consequence == known.consequence;
         });
}

/// The first data line that is not blank; the first where there is none.
int first_line(const KeptBlock& block) {
  const auto found = std::ranges::find_if(block.lines, [](const auto& line) { return !line.fields.empty(); });
  return found == block.lines.end() ? 0 : static_cast<int>(found - block.lines.begin());
}

bool is_section(const Keyword& keyword) { return keyword.name.ends_with("SECTION"); }

void AbaqusText::keep(const Keyword& keyword, abaqus::DeckLines& lines, const abaqus::Problems& problems,
                      std::string& material) {
  const auto where = problems.location(keyword.where);
  const bool is_option = is_of_material(keyword.name);
  if (!is_option) keywords_.push_back(where);
  if (keyword.name == "MATERIAL") {
    material = upper_case(keyword.get("NAME"));
    materials_.insert(material);
  }
  static const std::set<std::string, std::less<>> others = {"MATERIAL", "ELASTIC", "DENSITY", "SPRING", "MASS"};
  if (!is_section(keyword) && !others.contains(keyword.name)) return;
  KeptBlock block{keyword, where, {}, is_option || keyword.name == "MATERIAL" ? material : ""};
  for (std::string_view line; lines.next_data_or_blank(line);)
    block.lines.push_back({lines.where(), line.empty() ? std::vector<std::string>{} : abaqus::split_fields(line)});
  while (!block.lines.empty() && block.lines.back().fields.empty()) block.lines.pop_back();
  blocks_.push_back(std::move(block));
}

/// The keyword that states a region's section, a stiffness or a mass.
std::size_t AbaqusText::block_at(const std::string& name) const {
  const auto origin = origins_.find(name);
  if (origin == origins_.end()) throw Unwritable("no keyword of the deck states it alone", "change the deck by hand");
  for (std::size_t i = 0; i < blocks_.size(); ++i)
    if (blocks_[i].where.line == origin->second.line && blocks_[i].where.file == origin->second.file) return i;
  throw Unwritable("its keyword is not found", "change the deck by hand");
}

std::vector<FieldPlace> AbaqusText::fields_of(const std::string& parameter) const {
  const auto [name, quantity] = split_name(parameter);
  if (quantity == "thickness") return thickness_fields(block_at(name));
  if (quantity == "mass") return {{block_at(parameter), first_line(blocks_[block_at(parameter)]), 0}};
  if (quantity == "stiffness") return spring_fields(block_at(parameter));
  throw Unwritable("no field of the deck states it", "change the deck by hand");
}

std::vector<FieldPlace> AbaqusText::thickness_fields(std::size_t block) const {
  const auto& keyword = blocks_[block].keyword;
  if (keyword.has("NODALTHICKNESS"))
    throw Unwritable("the thickness is given at the nodes (NODAL THICKNESS)", "change it there by hand");
  const auto offset = keyword.word("OFFSET");
  if (!offset.empty() && offset != "MID" && abaqus::to_number(offset) != 0.0)
    throw Unwritable("OFFSET of the section is a fraction of the thickness: the surface would move with it",
                     "write thickness and OFFSET by hand, so that their product stays");
  return {{block, first_line(blocks_[block]), 0}};
}

// The first line of a spring names its directions, except where SPRINGA leaves it out.
std::vector<FieldPlace> AbaqusText::spring_fields(std::size_t block) const {
  const auto& lines = blocks_[block].lines;
  std::vector<FieldPlace> places;
  const bool has_directions = lines.size() > 1 && (lines[0].fields.empty() || abaqus::to_integer(lines[0].field(0)) ||
                                                   lines[0].field(0).empty());
  for (std::size_t i = has_directions ? 1 : 0; i < lines.size(); ++i)
    if (!lines[i].fields.empty()) places.push_back({block, static_cast<int>(i), 0});
  return places;
}

// Rows by temperature are multiplied alike, so that what is interpolated between them is, too.
std::vector<FieldPlace> AbaqusText::material_fields(const std::string& material, const std::string& quantity) const {
  const bool is_density = quantity == "density";
  std::vector<FieldPlace> places;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const auto& block = blocks_[i];
    if (block.material != upper_case(material) || block.keyword.name != (is_density ? "DENSITY" : "ELASTIC")) continue;
    const auto type = block.keyword.word("TYPE");
    if (!is_density && !type.empty() && !type.starts_with("ISO"))
      throw Unwritable("the material is not isotropic: it has no one modulus", "change its constants by hand");
    for (std::size_t k = 0; k < block.lines.size(); ++k)
      if (!block.lines[k].fields.empty()) places.push_back({i, static_cast<int>(k), 0});
  }
  if (places.empty())
    throw Unwritable(is_density ? "the material has no *DENSITY" : "the material has no *ELASTIC",
                     "add it, and update again");
  return places;
}

// Materials of sections stand in the keyword, those of layers in field 3 of their lines.
std::vector<MaterialUse> AbaqusText::uses_of(const std::string& material, const FiniteElementModel& model) const {
  std::vector<MaterialUse> uses;
  const std::string name = upper_case(material);
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const auto& block = blocks_[i];
    if (!is_section(block.keyword)) continue;
    MaterialUse use;
    if (upper_case(block.keyword.get("MATERIAL")) == name)
      use.references.push_back({i, keyword_line, material_parameter});
    if (block.keyword.has("COMPOSITE"))
      for (std::size_t k = 0; k < block.lines.size(); ++k)
        if (upper_case(block.lines[k].field(2)) == name) use.references.push_back({i, static_cast<int>(k), 2});
    if (use.references.empty()) continue;
    for (const auto& [region, property] : model.properties)
      if (const auto origin = origins_.find(region); origin != origins_.end() &&
                                                     origin->second.line == block.where.line &&
                                                     origin->second.file == block.where.file)
        use.regions.push_back(region);
    use.is_fixed = use.regions.empty();  // trusses
    uses.push_back(std::move(use));
  }
  return uses;
}

/// Where a line begins in the text of its file.
std::size_t AbaqusText::line_begin(const SourceLocation& where) const {
  const std::string& text = texts_.at(where.file);
  std::size_t at = 0;
  for (int line = 1; line < where.line; ++line) at = text.find('\n', at) + 1;
  return at;
}

std::string AbaqusText::content_of(const FieldPlace& place) const {
  const auto& block = blocks_[place.card];
  if (place.line == keyword_line) return block.keyword.get(parameter_name(place.field));
  const auto line = static_cast<std::size_t>(place.line);
  return line < block.lines.size() ? block.lines[line].field(static_cast<std::size_t>(place.field)) : "";
}

double AbaqusText::number(const FieldPlace& place) const {
  const std::string text = content_of(place);
  const auto value = abaqus::to_number(text);
  if (!value || *value == 0.0)
    throw Unwritable(fmt::format("{} of {} is '{}'", field_title(place), blocks_[place.card].keyword.title, text),
                     "a field that is multiplied needs a number other than 0");
  return *value;
}

AbaqusText::Span AbaqusText::span_of(const FieldPlace& place) const {
  const auto& block = blocks_[place.card];
  const std::string content = content_of(place);
  if (place.line == keyword_line) {
    // The value behind NAME=, with blanks anywhere between; a keyword may run over several lines.
    const std::size_t begin = line_begin(block.where);
    const std::string capitals = upper_case(texts_.at(block.where.file).substr(begin, 4096));
    for (std::size_t at = capitals.find(parameter_name(place.field)); at != std::string::npos;
         at = capitals.find(parameter_name(place.field), at + 1)) {
      auto value = capitals.find_first_not_of(" \t", at + std::string_view(parameter_name(place.field)).size());
      if (value == std::string::npos || capitals[value] != '=') continue;
      value = capitals.find(upper_case(content), value);
      if (value != std::string::npos) return {block.where.file, begin + value, content.size()};
    }
    throw Unwritable("a parameter of " + block.keyword.title + " is not found", "change the deck by hand");
  }
  const SourceLocation where{block.where.file, block.lines[static_cast<std::size_t>(place.line)].where.line};
  const std::string& text = texts_.at(where.file);
  std::size_t at = line_begin(where);
  for (int i = 0; i < place.field; ++i) at = text.find(',', at) + 1;
  return {where.file, text.find(content, at), content.size()};
}

/// From *MATERIAL to the next keyword that is no part of it.
AbaqusText::Span AbaqusText::span_of_material(const std::string& material) const {
  for (const auto& block : blocks_) {
    if (block.keyword.name != "MATERIAL" || block.material != upper_case(material)) continue;
    int end = 0;
    for (const auto& other : keywords_)
      if (other.file == block.where.file && other.line > block.where.line && (end == 0 || other.line < end))
        end = other.line;
    const std::size_t begin = line_begin(block.where);
    const std::size_t length =
        end == 0 ? texts_.at(block.where.file).size() - begin : line_begin({block.where.file, end}) - begin;
    return {block.where.file, begin, length};
  }
  throw Unwritable("its *MATERIAL is not found", "change the deck by hand");
}

void AbaqusText::split(const std::string& material, const Numbers& numbers, const std::vector<MaterialUse>& users,
                       const std::string& cause) {
  std::string name;
  for (int i = 2; name.empty() || materials_.contains(upper_case(name)); ++i) name = material + "_" + std::to_string(i);
  const Span whole = span_of_material(material);
  TextEdits copied;
  std::vector<DeckFieldChange> made;
  const std::string remark = "*MATERIAL " + material + " is split: what is not updated keeps it";
  for (const auto& [place, value, own_cause] : numbers) {
    const Span span = span_of(place);
    if (span.file != whole.file || span.at < whole.at || span.at >= whole.at + whole.length)
      throw Unwritable("*MATERIAL " + material + " would have to be split, and stands in several files",
                       "give what is updated a material of its own");
    copied.replace(span.at - whole.at, span.length, abaqus_real(value));
    made.push_back(change_of({place, abaqus_real(value), own_cause, remark}));
    made.back().card += " of " + name;
  }
  std::string text = texts_.at(whole.file).substr(whole.at, whole.length);
  const std::size_t written = upper_case(text).find(upper_case(material), text.find('='));
  copied.replace(written, material.size(), name);
  text = copied.applied(text);
  if (!text.ends_with('\n')) text.insert(0, "\n");
  materials_.insert(upper_case(name));
  inserted_[whole.file].insert(whole.at + whole.length, text);
  added_.push_back({cause, {whole.file, 0}, "*MATERIAL " + name, "new keyword", "", "copy of " + material, remark});
  added_.insert(added_.end(), made.begin(), made.end());
  for (const auto& user : users)
    for (const auto& reference : user.references) edits_.push_back({reference, name, cause, remark});
}

DeckFieldChange AbaqusText::change_of(const Edit& edit) const {
  const auto& block = blocks_[edit.place.card];
  std::string card = block.keyword.title;
  const std::string owner = block.material.empty() ? block.keyword.get("ELSET") : block.material;
  if (!owner.empty()) card += " of " + owner;
  const SourceLocation where =
      edit.place.line == keyword_line
          ? block.where
          : SourceLocation{block.where.file, block.lines[static_cast<std::size_t>(edit.place.line)].where.line};
  return {edit.cause, where, card, field_title(edit.place), content_of(edit.place), edit.content, edit.remark};
}

Texts AbaqusText::apply(std::vector<DeckFieldChange>& changes) {
  std::map<std::string, TextEdits> of_file = inserted_;
  for (const auto& edit : edits_) {
    const Span span = span_of(edit.place);
    of_file[span.file].replace(span.at, span.length, edit.content);
    changes.push_back(change_of(edit));
  }
  changes.insert(changes.end(), added_.begin(), added_.end());
  Texts texts;
  for (const auto& [file, file_edits] : of_file) texts[file] = file_edits.applied(texts_.at(file));
  return texts;
}

}  // namespace

std::unique_ptr<DeckText> abaqus_text(const std::string& content, const std::string& source, const DeckLoader& loader,
                                      const DeckOrigins& origins) {
  return std::make_unique<AbaqusText>(content, source, loader, origins);
}

}  // namespace kalfem::rewriting
