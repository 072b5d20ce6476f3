// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/rewriting/nastran_line.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "kalfem/formats/nastran/card.hpp"
#include "kalfem/formats/tables/text_table.hpp"

namespace kalfem::rewriting {
namespace {

/// Of a field of 8 columns, relative: E, rho and t of a plate together move a frequency by less than 1e-5.
constexpr double largest_rounding = 2e-6;

/// Without zeros at the end of its decimals and in front of its point.
std::string tidy(std::string mantissa) {
  if (mantissa.find('.') == std::string::npos) mantissa += '.';
  mantissa.erase(mantissa.find_last_not_of('0') + 1);
  const auto start = mantissa.find_first_not_of('-');
  if (mantissa.compare(start, 2, "0.") == 0 && mantissa.size() > start + 2) mantissa.erase(start, 1);
  return mantissa;
}

/// A number as text. Of those that are as good, a lower rank is what people write.
struct Writing {
  std::string text;
  int rank = 0;
};

/// The value to so many digits in each way of writing it: 21000., 2.1+4, 21.+3.
std::vector<Writing> writings(double value, int digits) {
  const std::string scientific = fmt::format("{:.{}e}", value, digits - 1);
  const auto e = scientific.find('e');
  const int exponent = std::stoi(scientific.substr(e + 1));
  std::vector<Writing> all;
  if (exponent > -5 && exponent < 16)
    all.push_back({tidy(fmt::format("{:.{}f}", value, std::max(0, digits - 1 - exponent))), exponent < 6 ? 0 : 3});
  all.push_back({tidy(scientific.substr(0, e)) + fmt::format("{:+d}", exponent), 1});
  std::string whole = scientific.substr(0, e);
  std::erase(whole, '.');
  if (digits > 1) all.push_back({whole + '.' + fmt::format("{:+d}", exponent - digits + 1), 2});
  return all;
}

double rounding(const std::string& text, double value) {
  const auto read = nastran::parse_real(text);
  if (!read) return std::numeric_limits<double>::infinity();
  return value == 0.0 ? std::abs(*read) : std::abs(*read - value) / std::abs(value);
}

std::string padded(std::string_view text, std::size_t width, bool to_the_right = false) {
  return to_the_right ? fmt::format("{:>{}}", text, width) : fmt::format("{:<{}}", text, width);
}

void trim_end(std::string& text) { text.erase(text.find_last_not_of(' ') + 1); }

std::string text_of(const LineEdit& edit, std::size_t width) {
  if (const auto* text = std::get_if<std::string>(&edit.content)) return *text;
  return nastran_real(std::get<double>(edit.content), width);
}

// Widths count for nothing between commas; 16 characters hold 1e-9.
RewrittenLine free_line(std::string_view line, const std::vector<LineEdit>& edits) {
  RewrittenLine result;
  std::map<std::size_t, std::size_t> order;
  for (std::size_t i = 0; i < edits.size(); ++i) {
    order[edits[i].at] = i;
    result.contents.push_back(text_of(edits[i], 16));
  }
  std::size_t from = 0;
  for (const auto& [at, i] : order) {
    result.text.append(line.substr(from, at - from)).append(result.contents[i]);
    from = at + edits[i].length;
  }
  result.text.append(line.substr(from));
  return result;
}

/// A line of columns taken apart.
struct Columns {
  std::string name;                 ///< or marker of a continuation
  std::vector<std::string> fields;  ///< as wide as they are
  std::string rest;                 ///< from column 73 on
};

Columns columns_of(std::string_view line, std::size_t width) {
  const std::string full = padded(line, 72);
  Columns columns{full.substr(0, 8), {}, full.substr(72)};
  for (std::size_t at = 8; at < 72; at += width) columns.fields.push_back(full.substr(at, width));
  return columns;
}

std::string with_asterisk(std::string_view name) {
  const auto bare = trimmed(name);
  if (bare.starts_with('+')) return "*" + std::string(bare.substr(1));
  return bare.empty() ? "*" : std::string(bare) + "*";
}

/// Two lines of four large fields; the first has no marker, so that the second follows it.
std::string large_lines(const Columns& columns) {
  std::string first = padded(with_asterisk(columns.name), 8), second = padded("*", 8);
  for (std::size_t i = 0; i < 8; ++i) (i < 4 ? first : second) += padded(trimmed(columns.fields[i]), 16);
  second += columns.rest;
  trim_end(first);
  trim_end(second);
  return first + "\n" + second;
}

}  // namespace

// Of all writings that fit, the one with the smallest rounding; of these the most usual, and the shortest.
std::string nastran_real(double value, std::size_t width) {
  std::tuple<double, int, std::size_t, std::string> best{std::numeric_limits<double>::infinity(), 0, 0, ""};
  for (int digits = 17; digits >= 1; --digits)
    for (const auto& [text, rank] : writings(value, digits))
      if (text.size() <= width) best = std::min(best, {rounding(text, value), rank, text.size(), text});
  return std::get<3>(best);
}

RewrittenLine rewritten_line(std::string_view line, const std::vector<LineEdit>& edits) {
  const std::string_view comment = line.find('$') == std::string_view::npos ? "" : line.substr(line.find('$'));
  const std::string_view body = line.substr(0, line.size() - comment.size());
  if (body.find(',') != std::string_view::npos) return free_line(line, edits);
  const bool is_large = body.substr(0, 8).find('*') != std::string_view::npos;
  const std::size_t width = is_large ? 16 : 8;
  Columns columns = columns_of(body, width);
  RewrittenLine result;
  for (const auto& edit : edits) {
    const auto* value = std::get_if<double>(&edit.content);
    result.became_large |= !is_large && value && rounding(nastran_real(*value, 8), *value) > largest_rounding;
  }
  for (const auto& edit : edits) {
    auto& field = columns.fields[(edit.at - 8) / width];
    const bool to_the_right = field.front() == ' ' && field.back() != ' ';
    result.contents.push_back(text_of(edit, result.became_large ? 16 : width));
    field = padded(result.contents.back(), width, to_the_right);
  }
  if (result.became_large) {
    result.text = large_lines(columns);
  } else {
    result.text = columns.name;
    for (const auto& field : columns.fields) result.text += field;
    result.text += columns.rest;
    // Blanks at the end stay as many as they were.
    while (result.text.size() > body.size() && result.text.back() == ' ') result.text.pop_back();
  }
  if (!comment.empty() && result.became_large) result.text = padded(result.text, 0) + ' ';
  result.text += comment;
  return result;
}

}  // namespace kalfem::rewriting
