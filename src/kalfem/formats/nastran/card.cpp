// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/nastran/card.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "kalfem/formats/gmsh/gmsh_scanner.hpp"

namespace kalfem::nastran {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// Nastran writes 7.0E+3 also as 7.0+3 or 7.D3. A sign that is not at the start and not behind the letter begins the
// exponent. A second exponent, or one without digits before it, makes the field no number.
/// The number as std::from_chars reads it: no leading '+', 'e' before each exponent. Empty where it is none.
std::string_view normalised(std::string_view field, std::array<char, 64>& buffer) {
  std::size_t size = 0;
  bool in_exponent = false, has_digit = false;
  for (std::size_t i = 0; i < field.size(); ++i) {
    char c = field[i];
    const bool sign = c == '+' || c == '-';
    if (c == 'D' || c == 'd' || c == 'E') c = 'e';
    if (size + 2 > buffer.size() || !(is_digit(c) || sign || c == 'e' || c == '.')) return {};
    if (is_digit(c)) has_digit = true;
    if (c == 'e') {
      if (in_exponent || !has_digit) return {};
      in_exponent = true;
    } else if (sign && i > 0 && (size == 0 || buffer[size - 1] != 'e')) {
      if (in_exponent || !has_digit) return {};
      in_exponent = true;
      buffer[size++] = 'e';
    }
    if (c == '+' && i == 0) continue;
    buffer[size++] = c;
  }
  return has_digit ? std::string_view(buffer.data(), size) : std::string_view{};
}

}  // namespace

std::optional<std::int64_t> parse_integer(std::string_view field) {
  if (field.starts_with('+')) {
    field.remove_prefix(1);
    if (field.starts_with('-')) return std::nullopt;
  }
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc{} || end != field.data() + field.size()) return std::nullopt;
  return value;
}

std::optional<double> parse_real(std::string_view field) {
  std::array<char, 64> buffer;
  const auto text = normalised(field, buffer);
  if (text.empty()) return std::nullopt;
  // from_chars knows "e+3" and "e-3"; a sign after the 'e' stays as it is.
  const char* begin = text.data();
  const char* const last = begin + text.size();
  double value = 0.0;
  const auto [end, error] = std::from_chars(begin, last, value);
  if (end != last) return std::nullopt;
  if (error == std::errc::result_out_of_range) {
    const auto exponent = text.find('e');
    const bool tiny = exponent != std::string_view::npos && text.substr(exponent).starts_with("e-");
    return tiny ? std::optional(0.0) : std::nullopt;
  }
  if (error != std::errc{} || !std::isfinite(value)) return std::nullopt;
  return value;
}

namespace {

constexpr Id largest_id = std::numeric_limits<Id>::max();

std::string field_title(const char* what, std::size_t i) {
  return std::string(what) + " (line " + std::to_string((i - 1) / 8 + 1) + " of the card, field " +
         std::to_string((i - 1) % 8 + 2) + ")";
}

[[noreturn]] void fail(const Card& card, std::size_t i, const char* what, const std::string& needed) {
  const auto found = card.blank(i) ? std::string("blank") : "'" + printable(card.raw(i)) + "'";
  throw CardError(title(card) + ": " + field_title(what, i) + " is " + found, "it must be " + needed,
                  "correct the field");
}

/// Takes a number out of the last range by parting it.
void take_out(std::vector<IdRange>& list, Id number) {
  const IdRange range = list.back();
  if (number < range.first || (number - range.first) % range.step != 0) return;
  list.pop_back();
  if (number > range.first) list.push_back({range.first, number - range.step, range.step, false});
  if (number <= range.last - range.step) list.push_back({number + range.step, range.last, range.step, false});
  // Further numbers ascend; where nothing is left of the range an empty one stands for it.
  else
    list.push_back({number, number - 1, 1, false});
}

}  // namespace

std::string title(const Card& card) {
  return card.is_integer(1) ? card.name + " " + std::string(card.raw(1)) : card.name;
}

std::string place_on_card(std::size_t i) {
  return "line " + std::to_string((i - 1) / 8 + 1) + ", field " + std::to_string((i - 1) % 8 + 2);
}

bool Card::is_integer(std::size_t i) const { return parse_integer(raw(i)).has_value(); }

bool Card::is_number(std::size_t i) const { return parse_real(raw(i)).has_value(); }

void Card::mark(std::size_t i, FieldUse use) const {
  if (i < 1 || i > fields.size()) return;
  if (uses.size() < i) uses.resize(fields.size(), FieldUse::untouched);
  uses[i - 1] = use;
}

std::string Card::text(std::size_t i) const {
  mark(i, FieldUse::used);
  return upper_case(raw(i));
}

bool Card::says(std::size_t i, std::string_view word) const {
  const bool found = upper_case(raw(i)) == word;
  if (found) mark(i, FieldUse::used);
  return found;
}

std::int64_t Card::integer(std::size_t i, const char* what) const {
  mark(i, FieldUse::used);
  const auto value = parse_integer(raw(i));
  if (!value) fail(*this, i, what, "a whole number");
  return *value;
}

std::int64_t Card::integer_or(std::size_t i, std::int64_t otherwise, const char* what) const {
  return blank(i) ? otherwise : integer(i, what);
}

Id Card::id(std::size_t i, const char* what) const {
  const auto value = integer(i, what);
  if (value < 1 || value > largest_id)
    fail(*this, i, what, "a positive number of at most " + std::to_string(largest_id));
  return static_cast<Id>(value);
}

Id Card::id_or(std::size_t i, Id otherwise, const char* what) const {
  if (blank(i)) return otherwise;
  const auto value = integer(i, what);
  if (value < -1 || value > largest_id) fail(*this, i, what, "a number from 0 to " + std::to_string(largest_id));
  return static_cast<Id>(value);
}

double Card::real(std::size_t i, const char* what) const {
  mark(i, FieldUse::used);
  const auto value = parse_real(raw(i));
  if (!value) fail(*this, i, what, "a finite number");
  return *value;
}

double Card::real_or(std::size_t i, double otherwise, const char* what) const {
  return blank(i) ? otherwise : real(i, what);
}

unsigned Card::components(std::size_t i, const char* what) const {
  unsigned set = 0;
  mark(i, FieldUse::used);
  if (raw(i) == "0") return set;
  for (const char c : raw(i)) {
    if (c == ' ') continue;
    if (c < '1' || c > '6') fail(*this, i, what, "directions from 1 to 6, such as 123");
    set |= 1u << (c - '1');
  }
  return set;
}

int Card::component(std::size_t i, const char* what) const {
  const auto value = integer_or(i, 0, what);
  if (value < 0 || value > 6) fail(*this, i, what, "one direction from 1 to 6, or 0 for a scalar point");
  return value == 0 ? 0 : static_cast<int>(value) - 1;
}

// Items are numbers, "n1 THRU n2", "n1 THRU n2 BY step" and "n1 THRU n2 EXCEPT n3 n4 ...". The exceptions end at the
// first number beyond the range, which is an item of its own.
std::vector<IdRange> Card::id_list(std::size_t first, const char* what) const {
  std::vector<IdRange> list;
  bool except = false;  // numbers are taken out of the last range
  const auto next_filled = [&](std::size_t i) {
    while (i < size() && blank(i)) ++i;
    return i;
  };
  for (std::size_t i = first; i <= size(); ++i) {
    if (blank(i)) continue;
    const auto word = text(i);
    if (word == "EXCEPT" && !list.empty() && !list.back().single) {
      except = true;
    } else if ((word == "THRU" || word == "TO") && !list.empty() && list.back().single) {
      i = next_filled(i + 1);
      auto& range = list.back();
      range.single = false;
      range.last = id(i, what);
      if (range.last < range.first) fail(*this, i, what, "the end of an ascending range");
      if (says(i + 1, "BY")) range.step = id(i + 2, "BY"), i += 2;
      except = false;
    } else {
      const Id number = id(i, what);
      except = except && number <= list.back().last;
      if (!except)
        list.push_back({number, number, 1, true});
      else
        take_out(list, number);
    }
  }
  return list;
}

}  // namespace kalfem::nastran
