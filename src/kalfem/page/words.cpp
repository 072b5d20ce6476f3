// SPDX-License-Identifier: Apache-2.0
#include "kalfem/page/words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

namespace kalfem {
namespace {

/// Length as shown: UTF-8 continuation bytes take no room.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; }));
}

std::string padded(const std::string& text, std::size_t columns, bool right) {
  const std::string blank(columns - std::min(columns, width(text)), ' ');
  return right ? blank + text : text + blank;
}

}  // namespace

std::string per_cent(double ratio) { return std::isfinite(ratio) ? fmt::format("{:.2f} %", 100.0 * ratio) : "-"; }

Table without_empty_columns(Table table) {
  for (std::size_t c = table.columns.size(); c-- > 1;) {
    if (std::ranges::any_of(table.rows, [c](const auto& row) { return row[c] != "-"; })) continue;
    const auto at = static_cast<std::ptrdiff_t>(c);
    table.columns.erase(table.columns.begin() + at);
    for (auto& row : table.rows) row.erase(row.begin() + at);
  }
  return table;
}

std::string counted(Eigen::Index count, const std::string& noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

std::string four_digits(double value) { return std::isfinite(value) ? fmt::format("{:.4g}", value) : "-"; }

std::string to_text(const Table& table) {
  std::vector<std::size_t> widths;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    widths.push_back(width(table.columns[c]));
    for (const auto& row : table.rows) widths[c] = std::max(widths[c], width(row[c]));
  }
  std::string text;
  const auto add = [&](const std::vector<std::string>& cells) {
    std::string line;
    for (std::size_t c = 0; c < cells.size(); ++c) line += (c ? "   " : "  ") + padded(cells[c], widths[c], c > 0);
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  };
  add(table.columns);
  std::size_t total = 0;
  for (const auto w : widths) total += w + 3;
  text += "  " + std::string(total - 3, '-') + "\n";
  for (const auto& row : table.rows) add(row);
  return text;
}

std::string speed_in_words(double ratio) {
  return ratio >= 1.0 ? fmt::format("{:.3g} times faster than real time", ratio)
                      : fmt::format("{:.3g} times slower than real time", 1.0 / ratio);
}

std::string signed_per_cent(double ratio) {
  if (!std::isfinite(ratio)) return "-";
  const std::string words = fmt::format("{:+.2f} %", 100.0 * ratio);
  return words.substr(1) == "0.00 %" ? words.substr(1) : words;
}

std::string capitalised(std::string words) {
  const std::string first = words.substr(0, words.find(' '));
  const auto mark = first.find_first_of("._");
  const bool is_name = mark != std::string::npos && mark + 1 < first.size();
  if (!words.empty() && !is_name) words[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(words[0])));
  return words;
}

std::string sentence(std::string words) { return capitalised(std::move(words)) + "\n"; }

}  // namespace kalfem
