// SPDX-License-Identifier: Apache-2.0
#include "kalfem/yaml/yaml_mistakes.hpp"

#include <algorithm>
#include <optional>
#include <sstream>
#include <string_view>
#include <vector>

namespace kalfem {
namespace {

/// A line with content, in the block style: its indentation, and whether deeper lines may follow it.
struct BlockLine {
  int number = 0;
  std::size_t indent = 0;
  bool opens = false;  ///< it ends in ':' or in the sign of a text of several lines, begins an item of a list, or
                       ///< leaves a bracket or a brace open
};

std::optional<Issue> tab_in(const std::vector<std::string>& lines, const std::string& name, int last) {
  for (int number = 1; number <= std::min(last, static_cast<int>(lines.size())); ++number) {
    const std::string& line = lines[static_cast<std::size_t>(number) - 1];
    const std::size_t content = line.find_first_not_of(" \t");
    if (content != std::string::npos && line.find('\t') < content)
      return Issue{{name, number},
                   "the line is indented with a tab",
                   "YAML knows indentation by blanks only",
                   "replace the tab by blanks"};
  }
  return std::nullopt;
}

std::string blanks(std::size_t count) { return std::to_string(count) + (count == 1 ? " blank" : " blanks"); }

std::optional<BlockLine> block_line(const std::string& line, int number) {
  const std::size_t indent = line.find_first_not_of(' ');
  if (indent == std::string::npos || line[indent] == '#') return std::nullopt;
  std::string_view content = std::string_view(line).substr(indent);
  if (const auto comment = content.find(" #"); comment != std::string_view::npos) content = content.substr(0, comment);
  while (!content.empty() && (content.back() == ' ' || content.back() == '\r')) content.remove_suffix(1);
  const auto brackets = std::ranges::count_if(content, [](char c) { return c == '[' || c == '{'; }) -
                        std::ranges::count_if(content, [](char c) { return c == ']' || c == '}'; });
  const bool opens = content.ends_with(':') || content.ends_with('|') || content.ends_with('>') ||
                     content.ends_with('&') || content.starts_with("- ") || content == "-" || brackets > 0;
  return BlockLine{number, indent, opens};
}

/// The last line up to `last` that is deeper than the one before it, which holds a value already, or that returns to a
/// depth that no line above it has.
std::optional<Issue> blank_in(const std::vector<std::string>& lines, const std::string& name, int last) {
  std::vector<BlockLine> open;  // the lines that the present one is below, each deeper than the one before
  std::optional<Issue> found;
  for (int number = 1; number <= std::min(last, static_cast<int>(lines.size())); ++number) {
    const auto line = block_line(lines[static_cast<std::size_t>(number) - 1], number);
    if (!line) continue;
    const bool returns = !open.empty() && line->indent < open.back().indent;
    while (!open.empty() && line->indent < open.back().indent) open.pop_back();
    const bool deeper = open.empty() || line->indent > open.back().indent;
    const bool wrong = !open.empty() && deeper && (returns || !open.back().opens);
    if (wrong)
      found = Issue{{name, number},
                    "the line begins with " + blanks(line->indent) + ", line " + std::to_string(open.back().number) +
                        " above it with " + std::to_string(open.back().indent),
                    "keys of one map begin in the same column",
                    "take blanks out, or put the line below a key that ends in ':'"};
    else
      found.reset();
    if (!deeper) open.pop_back();
    open.push_back(*line);
  }
  return found;
}

}  // namespace

Issue yaml_mistake(const std::string& text, const std::string& name, int line, const std::string& symptom) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string each; std::getline(stream, each);) lines.push_back(each);
  if (const auto tab = tab_in(lines, name, line + 1)) return *tab;
  if (const auto blank = blank_in(lines, name, line)) return *blank;
  return {{name, line}, "this is not YAML", symptom, "check indentation, quotes and brackets"};
}

}  // namespace kalfem
