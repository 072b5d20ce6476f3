// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/nastran/card_stream.hpp"

#include <algorithm>
#include <functional>
#include <utility>

#include "kalfem/formats/gmsh/gmsh_scanner.hpp"
#include "kalfem/formats/tables/text_table.hpp"
#include "kalfem/formats/text_file.hpp"

namespace kalfem::nastran {
namespace {

constexpr std::size_t most_told = 12;
constexpr std::size_t deepest_include = 50;
constexpr std::size_t most_includes = 10'000;
/// A name in quotes ends within so many lines.
constexpr int longest_name = 20;

/// Without what stands behind '$' (outside quotes, as in the name of a file) and blanks at the end.
std::string_view without_comment(std::string_view text) {
  char quote = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '\'' || c == '"') {
      quote = text.find(c, i + 1) != std::string_view::npos ? c : '\0';
    } else if (c == '$') {
      text = text.substr(0, i);
      break;
    }
  }
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t' || text.back() == '\r')) text.remove_suffix(1);
  return text;
}

bool begins_include(std::string_view text) {
  text = trimmed(text);
  return text.size() > 7 && upper_case(text.substr(0, 7)) == "INCLUDE" &&
         std::string_view(" \t'\"=").find(text[7]) != std::string_view::npos;
}

}  // namespace

std::int32_t DeckFiles::add(const std::string& name) {
  names_.push_back(name);
  return static_cast<std::int32_t>(names_.size()) - 1;
}

SourceLocation DeckFiles::location(const Place& place) const {
  const auto file = static_cast<std::size_t>(place.file);
  return {file < names_.size() ? names_[file] : "", place.line};
}

void DeckFiles::problem(const Place& place, const std::string& what, const std::string& why, const std::string& fix) {
  const bool included = place.file > 0;
  problem_with_name(place, included ? without_quotations(what) : what, included ? without_quotations(why) : why, fix);
}

void DeckFiles::problem_with_name(const Place& place, const std::string& what, const std::string& why,
                                  const std::string& fix) {
  if (++count_ <= most_told) listed_.add(location(place), what, why, fix);
}

void DeckFiles::raise() const {
  IssueList all = listed_;
  if (!all.empty() && open_end_)
    all.add(location(*open_end_), "ENDDATA is missing", "the deck may be truncated", "export the file again");
  if (count_ > most_told)
    all.add(all.issues().back().location,
            "and " + std::to_string(count_ - most_told) + " more problems are not listed");
  all.raise();
}

DeckLines::DeckLines(std::string content, const std::string& source, IncludeLoader loader, DeckFiles& files)
    : loader_(std::move(loader)), files_(files) {
  open(std::move(content), source);
}

void DeckLines::open(std::string content, const std::filesystem::path& path) {
  ++opened_;
  texts_.push_back(std::move(content));
  stack_.push_back({path, texts_.back(), {files_.add(path.string()), 0}});
}

std::optional<std::pair<std::int32_t, std::size_t>> DeckLines::place_of(std::string_view part) const {
  const std::less_equal<> before;  // of pointers into different texts
  for (std::size_t i = 0; i < texts_.size(); ++i)
    if (const auto* begin = texts_[i].data();
        before(begin, part.data()) && before(part.data() + part.size(), begin + texts_[i].size()))
      return std::pair(static_cast<std::int32_t>(i), static_cast<std::size_t>(part.data() - begin));
  return std::nullopt;
}

std::optional<std::string_view> DeckLines::raw_line() {
  auto& file = stack_.back();
  if (file.rest.empty()) return std::nullopt;
  const std::size_t end = std::min(file.rest.find('\n'), file.rest.size());
  const auto text = file.rest.substr(0, end);
  const bool has_end = end < file.rest.size();
  file.rest.remove_prefix(std::min(end + 1, file.rest.size()));
  ++file.place.line;
  if (!has_end && stack_.size() > 1 && !without_comment(text).empty()) open_ends_.push_back(file.place);
  return text;
}

// Comments begin with $, and INCLUDE may stand anywhere. Its file name may be in quotes and go on over several lines.
// Files are a stack: an INCLUDE opens one on top, its end closes it. All texts stay alive, as cards hold views of them.
std::optional<DeckLine> DeckLines::next() {
  while (!stack_.empty()) {
    const auto raw = raw_line();
    if (!raw) {
      stack_.pop_back();
      continue;
    }
    if (raw->empty() || raw->front() == '$') continue;
    const Place place = stack_.back().place;
    if (begins_include(*raw)) {
      include(*raw, place);
      continue;
    }
    const auto text = without_comment(*raw);
    if (!text.empty()) return DeckLine{text, place};
  }
  return std::nullopt;
}

void DeckLines::include(std::string_view statement, const Place& place) {
  std::string_view rest = trimmed(trimmed(statement).substr(7));
  if (rest.starts_with('=')) rest = trimmed(rest.substr(1));
  std::string name;
  if (rest.starts_with('\'') || rest.starts_with('"')) {
    const char quote = rest.front();
    rest.remove_prefix(1);
    std::size_t end = rest.find(quote);
    for (int lines = 0; end == std::string_view::npos && lines < longest_name; ++lines) {
      name += trimmed(rest);
      const auto more = raw_line();
      if (!more) break;
      rest = *more;
      end = rest.find(quote);
    }
    if (end == std::string_view::npos)
      return files_.problem(place, "INCLUDE: the file name is not closed", "its closing quotation mark is missing",
                            "close it");
    name += trimmed(rest.substr(0, end));
  } else {
    name = trimmed(without_comment(rest));
  }
  std::ranges::replace(name, '\\', '/');
  const bool is_text = std::ranges::none_of(name, [](unsigned char c) { return c < ' ' || c == 0x7f; });
  const std::string title = "INCLUDE '" + (is_text ? name : printable(name)) + "'";
  if (name.empty()) return files_.problem(place, "INCLUDE without a file name", "", "name it");
  if (!loader_)
    return files_.problem(place, title + " cannot be followed", "this deck is read without access to other files");
  const auto beside = [&](const Open& file) { return (file.path.parent_path() / name).lexically_normal(); };
  if (stack_.size() >= deepest_include || opened_ >= most_includes)
    return files_.problem(place, title + " is nested more than " + std::to_string(deepest_include) +
                                     " levels deep, or there are more than " + std::to_string(most_includes));
  // Beside the file that includes, then beside the first one: programs differ in what names are relative to.
  std::vector<std::filesystem::path> places = {beside(stack_.back())};
  if (beside(stack_.front()) != places.front()) places.push_back(beside(stack_.front()));
  std::string tried, reason;
  for (const auto& path : places) {
    if (std::ranges::any_of(stack_, [&](const Open& file) { return file.path.lexically_normal() == path; }))
      return files_.problem_with_name(place, title + ": the file includes itself", "the inclusion would never end",
                                      "remove the INCLUDE");
    tried += (tried.empty() ? "'" : "' nor '") + path.string();
    std::string content;
    try {
      content = loader_(path);
    } catch (const InvalidInput& error) {
      if (reason.empty()) reason = error.issues().front().why;
      continue;
    }
    return open(std::move(content), path);
  }
  const std::string outcome = places.size() > 1 ? "neither " + tried + "' can be read" : tried + "' cannot be read";
  files_.problem_with_name(place, title + ": " + outcome, reason.empty() ? "the deck continues in that file" : reason,
                           "names are relative to the including file, or to the first file of the deck");
}

}  // namespace kalfem::nastran
