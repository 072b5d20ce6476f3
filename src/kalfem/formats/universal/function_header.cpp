// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/universal/function_header.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "kalfem/base/text.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/formats/unit_labels.hpp"
#include "kalfem/formats/universal/fields.hpp"

namespace kalfem {
namespace {

/// Columns of the five fields of text and numbers, "(1X,10A1,I10,I4)" twice after "2(I5,I10)".
constexpr std::size_t response_name = 31, response_node = 41, response_direction = 51, reference_name = 56,
                      reference_node = 66, reference_direction = 76;

std::string without_none(std::string_view text) {
  const std::string known = to_utf8(text);
  return known == "NONE" || known == "none" || known == "None" ? "" : known;
}

constexpr long most_points = 1L << 40;

bool is_direction(long direction) { return std::abs(direction) <= 6; }

/// Record 6 in the columns of the format; false where they do not hold it.
bool read_places_by_columns(std::string_view line, FunctionHeader& header) {
  const auto function = universal_integer(columns(line, 0, 5));
  const auto from = universal_integer(columns(line, response_node, 10));
  const auto direction = universal_integer(columns(line, response_direction, 4));
  const auto reference = universal_integer(columns(line, reference_node, 10));
  const auto along = universal_integer(columns(line, reference_direction, 4));
  const bool whole = universal_integer(columns(line, 5, 10)) && universal_integer(columns(line, 15, 5)) &&
                     universal_integer(columns(line, 20, 10));
  if (!whole || !function || !from || !direction || !reference || !along) return false;
  if (!is_direction(*direction) || !is_direction(*along)) return false;
  header.function = static_cast<int>(*function);
  header.response = {without_none(columns(line, response_name, 10)), *from, static_cast<int>(*direction)};
  header.reference = {without_none(columns(line, reference_name, 10)), *reference, static_cast<int>(*along)};
  return true;
}

/// The same where the columns are shifted: four numbers, then name, node, direction of response and reference, of which
/// the last name is one word.
bool read_places_by_words(std::string_view line, FunctionHeader& header) {
  const auto words = words_of(line);
  if (words.size() < 10) return false;
  const auto number = [&](std::size_t i) { return universal_integer(words[i]); };
  const std::size_t last = words.size() - 1;
  for (const std::size_t i :
       {std::size_t{0}, std::size_t{1}, std::size_t{2}, std::size_t{3}, last, last - 1, last - 3, last - 4})
    if (!number(i)) return false;
  if (!is_direction(*number(last)) || !is_direction(*number(last - 3))) return false;
  header.function = static_cast<int>(*number(0));
  std::string name(words[4]);
  for (std::size_t i = 5; i + 5 < words.size(); ++i) name += " " + std::string(words[i]);
  header.response = {without_none(name), *number(last - 4), static_cast<int>(*number(last - 3))};
  header.reference = {without_none(words[last - 2]), *number(last - 1), static_cast<int>(*number(last))};
  return true;
}

/// The six numbers of record 7 as text: between blanks, or in columns where numbers touch.
std::array<std::string_view, 6> abscissa_fields(std::string_view line) {
  std::array<std::string_view, 6> fields;
  const auto words = words_of(line);
  if (words.size() == 6) {
    std::ranges::copy(words, fields.begin());
    return fields;
  }
  constexpr std::array<std::size_t, 7> places = {0, 10, 20, 30, 43, 56, 69};
  for (std::size_t i = 0; i < 6; ++i) fields[i] = columns(line, places[i], places[i + 1] - places[i]);
  return fields;
}

void read_abscissa(UniversalReading& reading, FunctionHeader& header) {
  const std::string line = reading.line("the number of points");
  const auto fields = abscissa_fields(line);
  const auto type = universal_integer(fields[0]), points = universal_integer(fields[1]),
             spacing = universal_integer(fields[2]);
  if (!type || !points || !spacing || *points < 0 || *points > most_points || *spacing < 0 || *spacing > 1 ||
      !(*type == 2 || *type == 4 || *type == 5 || *type == 6))
    throw reading.source.problem(
        "data type '" + std::string(fields[0]) + "', number of points '" + std::string(fields[1]) + "', spacing '" +
            std::string(fields[2]) + "'",
        "the data type must be 2, 4, 5 or 6, the number not negative, the spacing 0 (uneven) or 1 (even)",
        "export the file again");
  header.double_precision = *type == 4 || *type == 6;
  header.complex = *type >= 5;
  header.points = static_cast<std::uint64_t>(*points);
  header.even = *spacing == 1;
  const auto first = fields[3].empty() ? std::optional(0.0) : universal_number(fields[3]);
  const auto step = fields[4].empty() ? std::optional(0.0) : universal_number(fields[4]);
  if (header.even && (!first || !step || !std::isfinite(*first) || !(std::isfinite(*step) && *step >= 0.0)))
    throw reading.source.problem(
        "the abscissa begins at '" + std::string(fields[3]) + "' and has the step '" + std::string(fields[4]) + "'",
        "an even abscissa needs a number and a step that is not negative", "export the file again");
  header.first = first.value_or(0.0);
  header.step = meant_step(fields[4], step.value_or(0.0));
}

/// Label and unit between runs of two blanks, where the columns are not those of the format.
void split_labels(std::string_view text, UniversalAxis& axis) {
  const std::size_t gap = text.find("  ");
  axis.label = without_none(text.substr(0, gap));
  axis.unit =
      gap == std::string_view::npos ? "" : understood_unit(without_none(columns(text, gap, std::string_view::npos)));
}

/// Records 8 to 11, "(I10,3I5,2(1X,20A1))". Labels of programs that count bytes or characters end at places that
/// differ by the characters of two bytes: the unit begins after the blank between them.
UniversalAxis read_axis(UniversalReading& reading, const std::string& wanted) {
  constexpr std::size_t label = 26, unit = 46;
  const std::string line = to_utf8(reading.line(wanted));
  UniversalAxis axis;
  const std::string_view text = line;
  std::array<std::optional<long>, 4> whole = {
      universal_integer(columns(text, 0, 10)), universal_integer(columns(text, 10, 5)),
      universal_integer(columns(text, 15, 5)), universal_integer(columns(text, 20, 5))};
  const auto words = words_of(text);
  const bool in_columns = std::ranges::all_of(whole, [](const auto& value) { return value.has_value(); });
  if (!in_columns && words.size() >= 4)
    for (std::size_t i = 0; i < 4; ++i) whole[i] = universal_integer(words[i]);
  if (!std::ranges::all_of(whole, [](const auto& value) { return value && std::abs(*value) < 1000; }))
    throw reading.source.problem(wanted + ": '" + std::string(columns(text, 0, 25)) + "'",
                                 "a data type and three exponents of units are required", "export the file again");
  axis.type = static_cast<int>(*whole[0]);
  axis.length = static_cast<int>(*whole[1]);
  axis.force = static_cast<int>(*whole[2]);
  axis.temperature = static_cast<int>(*whole[3]);
  if (!in_columns) {
    const auto rest = static_cast<std::size_t>(words[3].data() + words[3].size() - text.data());
    split_labels(columns(text, rest, std::string_view::npos), axis);
  } else if (text.size() > unit && text[unit - 1] != ' ' && text[unit] != ' ') {
    split_labels(columns(text, label - 1, std::string_view::npos), axis);
  } else {
    axis.label = without_none(columns(text, label - 1, unit - label + 1));
    axis.unit = understood_unit(without_none(columns(text, unit, std::string_view::npos)));
  }
  return axis;
}

/// Digits of a number from the first one that is not zero to the last one.
int significant_digits(std::string_view text) {
  std::string digits;
  for (const char c : text.substr(0, text.find_first_of("eEdD")))
    if (c >= '0' && c <= '9') digits += c;
  const std::size_t first = digits.find_first_not_of('0'), last = digits.find_last_not_of('0');
  return first == std::string::npos ? 0 : static_cast<int>(last - first + 1);
}

}  // namespace

FunctionHeader read_function_header(UniversalReading& reading) {
  FunctionHeader header{.line = reading.begin};
  for (auto& text : header.texts) text = without_none(columns(reading.line("the five lines of text"), 0, 80));
  const std::string places = reading.line("the identification of the degree of freedom");
  if (!read_places_by_columns(places, header) && !read_places_by_words(places, header))
    throw reading.source.problem(
        "'" + places.substr(0, 60) + "' is not the identification of a degree of freedom",
        "four whole numbers, then name, node and direction (-6 to 6) of the response and of the reference are required",
        "export the file again");
  read_abscissa(reading, header);
  constexpr std::array names = {"the abscissa", "the ordinate", "the denominator of the ordinate"};
  for (std::size_t i = 0; i < header.axes.size(); ++i) header.axes[i] = read_axis(reading, names[i]);
  reading.line("the z axis");
  return header;
}

BinaryForm binary_form(const std::string& identifier) {
  BinaryForm form;
  const std::size_t letter = identifier.find_first_of("bB");
  const std::string_view rest = std::string_view(identifier).substr(letter + 1);
  const auto words = words_of(rest);
  const auto number = [&](std::size_t i) { return i < words.size() ? universal_integer(words[i]).value_or(0) : 0; };
  form.byte_order = number(0);
  form.floating_point = number(1) == 0 ? 2 : number(1);
  form.text_lines = number(2) == 0 ? 11 : number(2);
  form.bytes = static_cast<std::uint64_t>(std::max(0L, number(3)));
  return form;
}

double meant_step(std::string_view text, double step) {
  constexpr int all_digits = 12;  ///< so many digits say the step itself
  const int digits = significant_digits(text);
  if (!(step > 0.0) || digits >= all_digits) return step;
  std::size_t decimals = 0;
  if (const std::size_t point = text.find('.'); point != std::string_view::npos)
    decimals = std::min(text.find_first_of("eEdD", point), text.size()) - point - 1;
  // half a unit of the last digit that is written, relative to the step
  const double mantissa = universal_number(text.substr(0, text.find_first_of("eEdD"))).value_or(0.0);
  const double rounding = 0.51 * std::pow(10.0, -static_cast<double>(decimals)) / std::abs(mantissa);
  const double rate = 1.0 / step;
  for (double scale = 1.0; scale <= 1e6; scale *= 10.0) {
    const double rounder = std::round(rate * scale) / scale;
    if (!(rounder > 0.0) || std::abs(rounder / rate - 1.0) > rounding) continue;
    return significant_digits(shortest(rounder)) < digits ? 1.0 / rounder : step;
  }
  return step;
}

}  // namespace kalfem
