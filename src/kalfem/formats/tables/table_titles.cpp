// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/tables/table_titles.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/text.hpp"
#include "kalfem/base/units.hpp"

namespace kalfem {
namespace {

using Cells = std::vector<std::string_view>;

std::optional<Unit> known_unit(const std::string& unit) {
  try {
    return parse_unit(unit);
  } catch (const InvalidInput&) {
    return std::nullopt;
  }
}

/// "[mm]" or "(mm)" without its brackets.
std::string_view without_brackets(std::string_view cell) {
  return cell.size() > 2 && (cell.front() == '[' || cell.front() == '(') ? cell.substr(1, cell.size() - 2) : cell;
}

constexpr std::array<std::string_view, 10> rate_words = {
    "sample rate",        "sampling rate", "samplerate",     "samplingrate", "sample frequency",
    "sampling frequency", "abtastrate",    "abtastfrequenz", "scan rate",    "fs"};
constexpr std::array<std::string_view, 9> interval_words = {"sample interval", "sampling interval", "sample period",
                                                            "sampling period", "time step",         "delta t",
                                                            "delta_t",         "abtastintervall",   "dt"};

/// Where a phrase ends that stands for itself in the text.
std::optional<std::size_t> end_of(std::string_view phrase, std::string_view text) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || static_cast<unsigned char>(c) >= 0x80; };
  for (std::size_t at = text.find(phrase); at != std::string_view::npos; at = text.find(phrase, at + 1)) {
    const std::size_t end = at + phrase.size();
    if ((at == 0 || !is_letter(text[at - 1])) && (end == text.size() || !is_letter(text[end]))) return end;
  }
  return std::nullopt;
}

template <std::size_t count>
std::optional<std::size_t> end_of_any(const std::array<std::string_view, count>& phrases, std::string_view text) {
  for (const auto phrase : phrases)
    if (const auto end = end_of(phrase, text)) return end;
  return std::nullopt;
}

/// The first number of a text and the unit behind or in brackets before it.
struct Quantity {
  double value = 0.0;
  std::string unit;
};

std::optional<Quantity> quantity_in(std::string_view text, char decimal) {
  const std::size_t first = text.find_first_of("0123456789");
  if (first == std::string_view::npos) return std::nullopt;
  std::size_t end = text.find_first_not_of("0123456789.,eE+-", first);
  if (end == std::string_view::npos) end = text.size();
  std::string_view digits = text.substr(first, end - first);
  while (!digits.empty() && (digits.back() < '0' || digits.back() > '9')) digits.remove_suffix(1);
  const auto value = parse_number(digits, decimal);
  if (!value || !(*value > 0.0) || !std::isfinite(*value)) return std::nullopt;
  Quantity found{*value, {}};
  const std::string_view before = text.substr(0, first), behind = text.substr(first + digits.size());
  const std::size_t open = before.find_first_of("[("), close = before.find_first_of("])");
  if (open != std::string_view::npos && close != std::string_view::npos && open < close) {
    found.unit = std::string(before.substr(open + 1, close - open - 1));
  } else {
    const std::size_t begin = behind.find_first_not_of(" \t,;\"[(");
    if (begin != std::string_view::npos)
      found.unit = std::string(behind.substr(begin, behind.find_first_of(" \t,;\"])", begin) - begin));
  }
  return found;
}

}  // namespace

std::optional<double> seconds_in(const std::string& unit) {
  const std::string word = lower_case(unit);
  if (word.empty() || word == "sec" || word == "second" || word == "seconds" || word == "sek") return 1.0;
  try {
    return to_si("1 " + unit, "s");
  } catch (const InvalidInput&) {
    return std::nullopt;
  }
}

bool is_unit_but_of_time(const std::string& unit) {
  return !unit.empty() && !seconds_in(unit) && known_unit(unit).has_value();
}

bool is_unit_cell(std::string_view cell) {
  if (cell.empty() || cell == "-") return true;
  if ((cell.front() == '[' && cell.back() == ']') || (cell.front() == '(' && cell.back() == ')')) return true;
  const std::string unit = to_utf8(cell);
  return !channel_of("x (" + unit + ")").unit.empty() || seconds_in(unit).has_value();
}

std::vector<Channel> table_titles(const Cells& names, const Cells& units, std::size_t width) {
  std::vector<Channel> titles;
  for (std::size_t i = 0; i < width; ++i) {
    Channel title = i < names.size() && !names[i].empty() ? channel_of(to_utf8(names[i])) : Channel{};
    if (title.name.empty()) title.name = "column_" + std::to_string(i + 1);
    if (i < units.size() && title.unit.empty() && units[i] != "-") title.unit = to_utf8(without_brackets(units[i]));
    titles.push_back(std::move(title));
  }
  return titles;
}

Cells names_in_comment(std::string_view text, const TextLine& first, char separator, char decimal, std::size_t width) {
  std::string_view comment;
  for (const TextLine& line : split_lines(text.substr(0, static_cast<std::size_t>(first.text.data() - text.data()))))
    if (!trimmed(line.text).empty()) comment = trimmed(line.text);
  while (!comment.empty() && (comment.front() == '#' || comment.front() == '%')) comment.remove_prefix(1);
  for (const char candidate : {separator, '\t', ';', ',', ' '}) {
    const Cells cells = split_cells(trimmed(comment), candidate);
    const auto is_name = [&](std::string_view cell) { return !cell.empty() && !parse_number(cell, decimal); };
    if (cells.size() == width && std::ranges::all_of(cells, is_name)) return cells;
  }
  return {};
}

std::optional<double> stated_rate(std::string_view line, char decimal) {
  const std::string text = lower_case(line);
  const auto quantity = [&](std::size_t end) { return quantity_in(line.substr(end), decimal); };
  if (const auto end = end_of_any(rate_words, text)) {
    const auto found = quantity(*end);
    if (!found) return std::nullopt;
    const auto unit = known_unit(found->unit);
    const Unit hertz = parse_unit("Hz");
    return found->value * (unit && unit->dimension == hertz.dimension ? unit->factor / hertz.factor : 1.0);
  }
  if (const auto end = end_of_any(interval_words, text))
    if (const auto found = quantity(*end)) return 1.0 / (found->value * seconds_in(found->unit).value_or(1.0));
  return std::nullopt;
}

}  // namespace kalfem
