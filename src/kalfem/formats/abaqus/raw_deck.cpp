// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/abaqus/raw_deck.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <map>

namespace kalfem::abaqus {

double number_or(const DataLine& line, std::size_t field, double otherwise, const std::string& what,
                 Problems& problems) {
  if (line.field(field).empty()) return otherwise;
  return number_at(line, field, what, problems).value_or(otherwise);
}

std::optional<double> number_at(const DataLine& line, std::size_t field, const std::string& what, Problems& problems) {
  const auto& text = line.field(field);
  const auto value = to_number(text);
  if (!value)
    problems.add(line.where, text.empty() ? "there is no " + what : "'" + to_string(text) + "' is not a number",
                 text.empty() ? "it has no default value" : "it should be " + what, "correct the line");
  return value;
}

std::vector<double> all_numbers(std::span<const DataLine> lines, const std::string& what, Problems& problems) {
  std::vector<double> values;
  for (const auto& line : lines)
    for (std::size_t field = 0; field < line.fields.size(); ++field)
      values.push_back(number_or(line, field, 0.0, what, problems));
  return values;
}

std::optional<double> number_parameter(const Keyword& keyword, std::string_view parameter, Problems& problems) {
  if (!keyword.has(parameter)) return {};
  const auto value = to_number(keyword.get(parameter));
  if (!value)
    problems.add(keyword.where, std::string(parameter) + "=" + to_string(keyword.get(parameter)) + " is not a number",
                 keyword.title + " expects a number here", "correct it");
  return value;
}

const DataLine& line_of(const Block& block, std::size_t index) {
  static const DataLine none;
  return index < block.lines.size() ? block.lines[index] : none;
}

namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

bool is_sign(char c) { return c == '+' || c == '-'; }

/// "+-1", "1e+-3": signs stand alone.
bool has_two_signs(std::string_view field) {
  for (std::size_t i = 1; i < field.size(); ++i)
    if (is_sign(field[i]) && is_sign(field[i - 1])) return true;
  return false;
}

/// What from_chars does not take: a leading plus, an exponent by D, or one without a letter (1.5-3).
std::optional<double> unusual_number(std::string_view field) {
  if (has_two_signs(field)) return {};
  if (field.starts_with('+')) field.remove_prefix(1);
  if (field.empty() || field.size() > 60) return {};
  std::string text(field);
  for (char& c : text)
    if (c == 'd' || c == 'D') c = 'e';
  if (text.find_first_of("eE") == std::string::npos)
    if (const auto sign = text.find_first_of("+-", 1); sign != std::string::npos) text.insert(sign, "e");
  if (const auto plus = text.find('+'); plus != std::string::npos) text.erase(plus, 1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size()) return {};
  if (error == std::errc::result_out_of_range && text.find("e-") != std::string::npos) return 0.0;
  if (error != std::errc{} || !std::isfinite(value)) return {};
  return value;
}

}  // namespace

std::string_view trimmed_field(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

std::string to_string(std::string_view field) {
  std::string text(field.substr(0, 40));
  for (char& c : text)
    if (!std::isprint(static_cast<unsigned char>(c))) c = '?';
  return field.size() > 40 ? text + "..." : text;
}

// Most fields are plain numbers, so the fast conversion comes first. A field that ends in a letter is none: this
// stops words such as "infinity" and "nan" before the slow path.
std::optional<double> to_number(std::string_view field) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error == std::errc{} && end == field.data() + field.size() && std::isfinite(value)) return value;
  if (field.empty() || std::isalpha(static_cast<unsigned char>(field.back()))) return {};
  return unusual_number(field);
}

std::optional<std::int64_t> to_integer(std::string_view field) {
  if (field.starts_with('+')) {
    field.remove_prefix(1);
    if (field.starts_with('-')) return {};
  }
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc{} || end != field.data() + field.size()) return {};
  return value;
}

std::optional<std::int64_t> to_label(std::string_view field) {
  const auto value = to_integer(field);
  return value && *value >= 1 && *value <= 1000000000000 ? value : std::nullopt;
}

// One field up to the next comma, blanks trimmed. A quoted field keeps its commas and blanks, if nothing but blanks
// follows the closing quote.
bool FieldCursor::next(std::string_view& field) {
  while (!rest_.empty() && is_blank(rest_.front())) rest_.remove_prefix(1);
  if (rest_.empty()) return false;
  if (rest_.front() == '"') {
    if (const auto quote = rest_.find('"', 1); quote != std::string_view::npos) {
      const auto comma = rest_.find(',', quote);
      if (trimmed_field(rest_.substr(0, comma)).size() == quote + 1) {
        field = rest_.substr(1, quote - 1);
        rest_.remove_prefix(comma == std::string_view::npos ? rest_.size() : comma + 1);
        return true;
      }
    }
  }
  const auto comma = rest_.find(',');
  field = trimmed_field(rest_.substr(0, comma));
  rest_.remove_prefix(comma == std::string_view::npos ? rest_.size() : comma + 1);
  return true;
}

std::vector<std::string> split_fields(std::string_view line) {
  std::vector<std::string> fields;
  FieldCursor cursor(line);
  for (std::string_view field; cursor.next(field);) fields.emplace_back(field);
  return fields;
}

namespace {

/// Letters behind the number of nodes that change nothing in a linear vibration, or nothing that is kept.
std::string remark_of(std::string_view suffix) {
  std::string remark;
  const auto mention = [&](const char* text) { remark += (remark.empty() ? "" : ", ") + std::string(text); };
  for (const char letter : suffix) {
    if (letter == 'H') mention("hybrid formulation (H): the pressure is not a separate unknown here");
    if (letter == 'M') mention("the modified formulation (M) is ignored");
    if (letter == 'T') mention("its temperatures (T) are ignored");
  }
  return remark;
}

bool consists_of(std::string_view text, std::string_view letters) {
  return text.find_first_not_of(letters) == std::string_view::npos;
}

// Letters choose the integration: R is reduced, I adds incompatible modes. The plain C3D8 of Abaqus has the mean
// dilatation instead; a hybrid one (H) is read like C3D8I. Wedges of 6 nodes are integrated by two points.
/// C3D followed by the number of nodes and letters.
std::optional<ElementType> solid_type(std::string_view name) {
  std::size_t digits = 0;
  int nodes = 0;
  while (digits < name.size() && digits < 3 && std::isdigit(static_cast<unsigned char>(name[digits])))
    nodes = 10 * nodes + (name[digits++] - '0');
  const auto suffix = name.substr(digits);
  static const std::map<int, CellShape> shapes = {{4, CellShape::tetrahedron4}, {6, CellShape::wedge6},
                                                  {8, CellShape::hexahedron8},  {10, CellShape::tetrahedron10},
                                                  {15, CellShape::wedge15},     {20, CellShape::hexahedron20}};
  const auto shape = shapes.find(nodes);
  if (shape == shapes.end() || !consists_of(suffix, "RHIMTS")) return {};
  ElementType type{Family::solid, shape->second, nodes};
  type.remark = remark_of(suffix);
  if (suffix.find_first_of("HM") == std::string_view::npos) type.remark_kind = DeckNoteKind::unused;
  const bool reduced = suffix.find('R') != std::string_view::npos;
  const bool incompatible = suffix.find('I') != std::string_view::npos;
  const bool hybrid = suffix.find('H') != std::string_view::npos;
  if (nodes == 8)
    type.kind = reduced                  ? SolidKind::reduced
                : incompatible || hybrid ? SolidKind::standard
                                         : SolidKind::mean_dilatation;
  else if (nodes == 6)
    type.kind = SolidKind::reduced;  // two points
  else if (nodes == 15 || nodes == 20)
    type.kind = reduced ? SolidKind::reduced : SolidKind::full;
  return type;
}

/// S followed by the number of nodes and letters.
std::optional<ElementType> shell_type(std::string_view name) {
  if (name.empty()) return {};
  const auto suffix = name.substr(1);
  static const std::map<char, std::pair<CellShape, int>> shapes = {{'3', {CellShape::triangle3, 3}},
                                                                   {'4', {CellShape::quadrilateral4, 4}},
                                                                   {'6', {CellShape::triangle6, 6}},
                                                                   {'8', {CellShape::quadrilateral8, 8}}};
  const auto shape = shapes.find(name.front());
  if (shape == shapes.end() || !consists_of(suffix, "RSWT5")) return {};
  ElementType type{Family::shell, shape->second.first, shape->second.second};
  type.remark = remark_of(suffix);
  if (suffix.find_first_of("HM") == std::string_view::npos) type.remark_kind = DeckNoteKind::unused;
  return type;
}

std::optional<ElementType> membrane_type(std::string_view name) {
  auto type = shell_type(name);
  if (type) {
    type->family = Family::membrane;
    type->remark = "it is read as a shell of negligible bending stiffness";
    type->remark_kind = DeckNoteKind::changed;
  }
  return type;
}

// The last digit is the interpolation: 31 linear, 32 quadratic with 3 nodes, 33 cubic, which has no shear
// deformation.
/// B or PIPE followed by 31, 32 or 33 and letters.
std::optional<ElementType> beam_type(std::string_view name) {
  if (name.size() < 2 || name.front() != '3' || !consists_of(name.substr(2), "RHOST")) return {};
  ElementType type{Family::beam, CellShape::line2, 2};
  if (name[1] == '2') {
    type.shape = CellShape::line3;
    type.nodes = 3;
  } else if (name[1] == '3') {
    type.shear_rigid = true;
  } else if (name[1] != '1') {
    return {};
  }
  type.remark = remark_of(name.substr(2));
  if (name.find("OS") != std::string_view::npos)
    type.remark = "warping is left free: torsion uses the St Venant constant only";
  return type;
}

const std::map<std::string, ElementType, std::less<>>& other_types() {
  static const std::string no_stiffness = "it has no mass, and stiffness at most while in contact";
  static const std::map<std::string, ElementType, std::less<>> types = {
      {"STRI3", {Family::shell, CellShape::triangle3, 3}},
      {"STRI65", {Family::shell, CellShape::triangle6, 6}},
      {"T3D2", {Family::truss, CellShape::line2, 2}},
      {"T3D2H", {Family::truss, CellShape::line2, 2}},
      {"T3D2T", {Family::truss, CellShape::line2, 2}},
      {"T3D3", {Family::truss, CellShape::line3, 3}},
      {"T3D3H", {Family::truss, CellShape::line3, 3}},
      {"SPRING1", {Family::ground_spring, CellShape::point1, 1}},
      {"SPRING2", {Family::spring, CellShape::line2, 2}},
      {"SPRINGA", {Family::axial_spring, CellShape::line2, 2}},
      {"DASHPOT1", {Family::ground_dashpot, CellShape::point1, 1}},
      {"DASHPOT2", {Family::dashpot, CellShape::line2, 2}},
      {"DASHPOTA", {Family::axial_dashpot, CellShape::line2, 2}},
      {"MASS", {Family::mass, CellShape::point1, 1}},
      {"ROTARYI", {Family::rotary_inertia, CellShape::point1, 1}},
      {"DCOUP3D", {Family::reference, CellShape::point1, 1}},
      {"R3D3", {Family::rigid, CellShape::triangle3, 3}},
      {"R3D4", {Family::rigid, CellShape::quadrilateral4, 4}},
      {"RB3D2", {Family::rigid, CellShape::line2, 2}},
      {"SFM3D3", {Family::without_stiffness, CellShape::triangle3, 3, {}, {}, no_stiffness, DeckNoteKind::unused}},
      {"SFM3D4", {Family::without_stiffness, CellShape::quadrilateral4, 4, {}, {}, no_stiffness, DeckNoteKind::unused}},
      {"SFM3D4R",
       {Family::without_stiffness, CellShape::quadrilateral4, 4, {}, {}, no_stiffness, DeckNoteKind::unused}},
      {"SFM3D6", {Family::without_stiffness, CellShape::triangle6, 6, {}, {}, no_stiffness, DeckNoteKind::unused}},
      {"SFM3D8", {Family::without_stiffness, CellShape::quadrilateral8, 8, {}, {}, no_stiffness, DeckNoteKind::unused}},
      {"SFM3D8R",
       {Family::without_stiffness, CellShape::quadrilateral8, 8, {}, {}, no_stiffness, DeckNoteKind::unused}},
      {"GAPUNI", {Family::without_stiffness, CellShape::line2, 2, {}, {}, no_stiffness, DeckNoteKind::unused}},
      {"GAPCYL", {Family::without_stiffness, CellShape::line2, 2, {}, {}, no_stiffness, DeckNoteKind::unused}},
      {"GAPSPHER", {Family::without_stiffness, CellShape::line2, 2, {}, {}, no_stiffness, DeckNoteKind::unused}}};
  return types;
}

}  // namespace

// Looks for the whole name first, then splits it into family, number of nodes and letters. Longer families come
// first, since B and S are prefixes of other names.
std::optional<ElementType> element_type(std::string_view given) {
  const std::string name = upper_case(given);
  if (const auto other = other_types().find(name); other != other_types().end()) return other->second;
  const std::string_view view = name;
  if (view.starts_with("C3D")) return solid_type(view.substr(3));
  if (view.starts_with("M3D")) return membrane_type(view.substr(3));
  if (view.starts_with("PIPE")) return beam_type(view.substr(4));
  if (view.starts_with("B")) return beam_type(view.substr(1));
  if (view.starts_with("S")) return shell_type(view.substr(1));
  return {};
}

}  // namespace kalfem::abaqus
