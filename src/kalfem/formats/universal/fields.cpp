// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/universal/fields.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "kalfem/base/text.hpp"
#include "kalfem/formats/matrices/entries.hpp"
#include "kalfem/formats/tables/text_table.hpp"

namespace kalfem {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_exponent_letter(char c) { return c == 'e' || c == 'E' || c == 'd' || c == 'D'; }
bool is_sign(char c) { return c == '+' || c == '-'; }

/// Length of the number that begins here and that another one may follow without a blank.
std::size_t number_length(std::string_view text) {
  std::size_t i = !text.empty() && is_sign(text.front()) ? 1 : 0;
  const auto digits = [&] {
    const std::size_t first = i;
    while (i < text.size() && is_digit(text[i])) ++i;
    return i - first;
  };
  digits();
  if (i < text.size() && text[i] == '.') ++i;
  digits();
  if (i >= text.size() || !(is_exponent_letter(text[i]) || is_sign(text[i]))) return i;
  const bool letter = is_exponent_letter(text[i]);
  std::size_t exponent = i + 1;
  if (letter && exponent < text.size() && is_sign(text[exponent])) ++exponent;
  const std::size_t mantissa = i;
  i = exponent;
  const std::size_t count = digits();
  if (!letter) return count == 3 && (i == text.size() || text[i] != '.') ? i : mantissa;
  const bool point = i < text.size() && text[i] == '.';
  return point && count >= 3 ? i - 1 : i;  // the digit before a point begins the next number
}

/// Numbers between blanks. False where there is another thing, which `odd` then is.
bool append_words(std::string_view line, std::vector<double>& numbers, std::string_view& odd) {
  for (std::size_t begin = line.find_first_not_of(" \t"); begin < line.size();) {
    const std::size_t end = std::min(line.find_first_of(" \t", begin), line.size());
    const auto number = universal_number(line.substr(begin, end - begin));
    if (!number) return odd = line.substr(begin, end - begin), false;
    numbers.push_back(*number);
    begin = line.find_first_not_of(" \t", end);
  }
  return true;
}

bool append_columns(std::string_view line, std::span<const int> widths, std::vector<double>& numbers) {
  while (!line.empty() && line.back() == ' ') line.remove_suffix(1);
  std::size_t place = 0;
  for (std::size_t field = 0; place < line.size(); ++field) {
    const auto width = static_cast<std::size_t>(widths[field % widths.size()]);
    const auto number = universal_number(columns(line, place, width));
    if (!number) return false;
    numbers.push_back(*number);
    place += width;
  }
  return true;
}

bool append_joined(std::string_view line, std::vector<double>& numbers) {
  for (const auto word : words_of(line)) {
    for (std::string_view rest = word; !rest.empty();) {
      const std::size_t length = number_length(rest);
      const auto number = universal_number(rest.substr(0, length));
      if (!number) return false;
      numbers.push_back(*number);
      rest.remove_prefix(length);
    }
  }
  return true;
}

}  // namespace

std::optional<double> universal_number(std::string_view text) {
  text = trimmed(text);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc() && end == text.data() + text.size())
    return std::isinf(value) ? std::nullopt : std::optional(value);
  const auto number = fortran_number(text);
  return number && std::isinf(*number) ? std::nullopt : number;
}

std::optional<long> universal_integer(std::string_view text) {
  text = trimmed(text);
  if (text.empty()) return 0;
  if (text.starts_with('+')) text.remove_prefix(1);
  long value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

std::string append_numbers(std::string_view line, std::span<const int> widths, std::vector<double>& numbers) {
  const std::size_t before = numbers.size();
  std::string_view odd;
  if (append_words(line, numbers, odd)) return {};
  numbers.resize(before);
  if (append_columns(line, widths, numbers)) return {};
  numbers.resize(before);
  if (append_joined(line, numbers)) return {};
  numbers.resize(before);
  return std::string(odd.substr(0, 40));
}

std::optional<std::vector<long>> integers_of(std::string_view line, std::size_t width) {
  while (!line.empty() && (line.back() == ' ' || line.back() == '\t')) line.remove_suffix(1);
  std::vector<long> values;
  const auto append = [&](std::string_view field) {
    const auto value = universal_integer(field);
    if (value) values.push_back(*value);
    return value.has_value();
  };
  const auto words = words_of(line);
  if (std::ranges::all_of(words, append) && values.size() * width >= line.size()) return values;
  values.clear();
  bool whole = true;
  for (std::size_t place = 0; place < line.size(); place += width) whole = whole && append(columns(line, place, width));
  if (whole) return values;
  values.clear();
  return std::ranges::all_of(words, append) ? std::optional(values) : std::nullopt;
}

std::vector<std::string_view> words_of(std::string_view line) { return split_cells(line, ' '); }

std::string_view columns(std::string_view line, std::size_t first, std::size_t count) {
  return first < line.size() ? trimmed(line.substr(first, count)) : std::string_view();
}

}  // namespace kalfem
