#include "kalfem/formats/abaqus/fields.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

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

std::vector<double> all_numbers(const Block& block, std::size_t first_line, const std::string& what,
                                Problems& problems) {
  std::vector<double> values;
  for (std::size_t i = first_line; i < block.lines.size(); ++i)
    for (std::size_t field = 0; field < block.lines[i].fields.size(); ++field)
      values.push_back(number_or(block.lines[i], field, 0.0, what, problems));
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

}  // namespace kalfem::abaqus
