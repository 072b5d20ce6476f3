// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/abaqus/deck_lines.hpp"

#include <algorithm>
#include <cctype>

#include "kalfem/formats/abaqus/raw_deck.hpp"
#include "kalfem/formats/text_file.hpp"

namespace kalfem::abaqus {

namespace {
constexpr std::size_t most_listed = 12;
}

int Problems::add_file(const std::string& name) {
  files_.push_back(name);
  return static_cast<int>(files_.size()) - 1;
}

// Texts of an included file are not quoted: it may be no deck at all. After a dozen problems reading stops.
void Problems::add(const Where& where, std::string what, std::string why, std::string fix) {
  if (where.file > 0) {
    what = without_quotations(what);
    why = without_quotations(why);
  }
  issues_.add(location(where), std::move(what), std::move(why), std::move(fix));
  if (issues_.issues().size() < most_listed) return;
  issues_.add(location(where), "reading stops here",
              "there are " + std::to_string(most_listed) + " problems up to here", "correct them first");
  raise();
}

void Problems::fail(const Where& where, std::string what, std::string why, std::string fix) {
  add(where, std::move(what), std::move(why), std::move(fix));
  raise();
  throw InvalidInput(issues_.issues());
}

namespace {

std::string joined_capitals(std::string_view text) {
  std::string result = upper_case(text);
  std::erase_if(result, [](char c) { return c == ' ' || c == '\t'; });
  return result;
}

/// Capitals with single blanks.
std::string title_of(std::string_view text) {
  std::string result;
  for (const char c : upper_case(trimmed_field(text)))
    if (c != ' ' && c != '\t')
      result += c;
    else if (!result.empty() && result.back() != ' ')
      result += ' ';
  return to_string(result);
}

/// The next part up to a comma outside of quotation marks; steps over it.
std::string_view take_part(std::string_view& rest) {
  bool quoted = false;
  std::size_t end = 0;
  for (; end < rest.size() && (quoted || rest[end] != ','); ++end)
    if (rest[end] == '"') quoted = !quoted;
  const auto part = rest.substr(0, end);
  rest.remove_prefix(std::min(rest.size(), end + 1));
  return part;
}

std::string_view unquoted(std::string_view value) {
  if (value.size() >= 2 && value.front() == '"' && value.back() == '"') return value.substr(1, value.size() - 2);
  return value;
}

}  // namespace

namespace {

/// The first parameter of that name, which counts as asked for; nullptr where there is none.
const Keyword::Parameter* asked_parameter(const Keyword& keyword, std::string_view name) {
  const auto found = std::ranges::find(keyword.parameters, name, &Keyword::Parameter::name);
  if (found == keyword.parameters.end()) return nullptr;
  found->asked = true;
  return &*found;
}

}  // namespace

bool Keyword::has(std::string_view parameter) const { return asked_parameter(*this, parameter) != nullptr; }

std::string Keyword::get(std::string_view parameter) const {
  const auto* found = asked_parameter(*this, parameter);
  return found ? found->value : std::string();
}

std::string Keyword::word(std::string_view parameter) const { return joined_capitals(get(parameter)); }

// "*SHELL SECTION, elset=a, material = b": the name and the parameters are compared in capitals without blanks,
// values keep their case. A comma between quotation marks separates nothing.
Keyword parse_keyword(std::string_view line, const Where& where) {
  Keyword keyword;
  keyword.where = where;
  line.remove_prefix(1);
  const auto name = take_part(line);
  keyword.name = joined_capitals(name);
  keyword.title = "*" + title_of(name);
  while (!line.empty()) {
    const auto part = take_part(line);
    const auto equals = part.find('=');
    const std::string parameter = joined_capitals(part.substr(0, equals));
    if (parameter.empty()) continue;
    const auto value =
        equals == std::string_view::npos ? std::string_view{} : unquoted(trimmed_field(part.substr(equals + 1)));
    keyword.parameters.push_back({parameter, std::string(value)});
  }
  return keyword;
}

namespace {

constexpr std::size_t deepest_inclusion = 50;
constexpr int most_files = 10000;

bool is_comment(std::string_view line) { return line.starts_with("**"); }

/// "MATERIAL=al, OFFSET=SPOS" or "NLGEOM", but no data.
bool looks_like_parameter(std::string_view line) {
  if (line.empty() || line.front() == '*') return false;
  if (line.find('=') != std::string_view::npos) return true;
  return std::isalpha(static_cast<unsigned char>(line.front())) != 0 && line.find(',') == std::string_view::npos;
}

std::string normal_path(const std::string& beside, std::string name) {
  std::ranges::replace(name, '\\', '/');
  const std::filesystem::path path(name);
  return (path.is_absolute() ? path : std::filesystem::path(beside).parent_path() / path).lexically_normal().string();
}

}  // namespace

DeckLines::DeckLines(std::string content, const std::string& source, const DeckLoader& loader, Problems& problems)
    : loader_(loader), problems_(problems) {
  files_.push_back(std::make_unique<File>(File{source, std::move(content), 0, problems_.add_file(source), 0}));
}

/// The next physical line without blanks around it, at the end of a file that of the including one.
bool DeckLines::read_line() {
  while (!files_.empty()) {
    File& file = *files_.back();
    if (file.at < file.content.size()) {
      const std::size_t end = std::min(file.content.find('\n', file.at), file.content.size());
      line_ = trimmed_field(std::string_view(file.content).substr(file.at, end - file.at));
      file.at = end + 1;
      line_where_ = {file.index, ++file.line};
      if (end == file.content.size() && !line_.empty() && line_.front() != '*')
        open_ends_.push_back({line_where_, files_.size() == 1});
      return true;
    }
    closed_ = std::move(files_.back());
    files_.pop_back();
  }
  return false;
}

// Looks at the next line without taking it. Comments (**) are passed over, and *INCLUDE is replaced by the lines of
// its file, so readers above see one stream of keywords and data.
DeckLines::Kind DeckLines::peek() {
  while (!pending_) {
    do
      if (!read_line()) return Kind::end;
    while (is_comment(line_));
    pending_ = !follow_include();
  }
  if (line_.empty()) return Kind::blank;
  return line_.front() == '*' ? Kind::keyword : Kind::data;
}

/// Enters a file where the line is an *INCLUDE.
bool DeckLines::follow_include() {
  if (line_.size() < 8 || line_.front() != '*' || upper_case(line_.substr(0, 8)) != "*INCLUDE") return false;
  const Where where = line_where_;
  const Keyword keyword = parse_keyword(joined_keyword(), where);
  if (keyword.name != "INCLUDE")
    problems_.fail(where, "the keyword " + keyword.title + " cannot be read", "", "correct it");
  if (keyword.get("INPUT").empty())
    problems_.fail(where, "*INCLUDE has no INPUT", "it must name the file to include", "write *INCLUDE, INPUT=<file>");
  insert(keyword.get("INPUT"), where);
  return true;
}

/// A keyword line with its continuation lines; a comma at the end announces one. Some decks end a complete keyword
/// with a comma: what follows belongs to it only if it looks like a parameter.
std::string DeckLines::joined_keyword() {
  std::string text(line_);
  if (files_.empty()) return text;
  File& file = *files_.back();
  std::size_t at = file.at;
  int number = file.line;
  while (text.ends_with(',') && at < file.content.size()) {
    const std::size_t end = std::min(file.content.find('\n', at), file.content.size());
    const auto line = trimmed_field(std::string_view(file.content).substr(at, end - at));
    at = end + 1;
    ++number;
    if (is_comment(line)) continue;
    if (!looks_like_parameter(line)) break;
    text.append(" ").append(line);
    file.at = at;
    file.line = number;
  }
  return text;
}

bool DeckLines::next_keyword(Keyword& keyword) {
  for (;;) {
    const Kind kind = peek();
    if (kind == Kind::end) return false;
    pending_ = false;
    if (kind != Kind::keyword) continue;
    where_ = line_where_;
    keyword = parse_keyword(joined_keyword(), where_);
    return true;
  }
}

bool DeckLines::next_data(std::string_view& line) {
  while (next_data_or_blank(line))
    if (!line.empty()) return true;
  return false;
}

bool DeckLines::next_data_or_blank(std::string_view& line) {
  const Kind kind = peek();
  if (kind != Kind::data && kind != Kind::blank) return false;
  pending_ = false;
  where_ = line_where_;
  line = line_;
  return true;
}

// Names of nested files are seen from the file that names them; decks that were written for other programs name them
// from the folder of the first file, which is tried next.
DeckLines::Loaded DeckLines::find(const std::string& name, const Where& where) {
  const std::string beside_file = normal_path(problems_.file(where.file), name);
  const std::string beside_deck = normal_path(problems_.file(0), name);
  try {
    return {beside_file, loader_(beside_file)};
  } catch (const InvalidInput& error) {
    if (beside_deck != beside_file) try {
        return {beside_deck, loader_(beside_deck)};
      } catch (const InvalidInput&) {
        // The first place is the one to name.
      }
    const std::string also = beside_deck == beside_file ? std::string() : ", or '" + beside_deck + "'";
    problems_.fail(where, "the included file " + to_string(name) + " cannot be read", error.issues().front().why,
                   "place it relative to the deck, as '" + beside_file + "'" + also + ", or correct the name");
  }
}

std::string DeckLines::load(const std::string& name, const Where& where) { return find(name, where).content; }

// A file that is open already would include itself for ever; the depth and the number of files are limited too.
void DeckLines::insert(const std::string& name, const Where& where) {
  if (files_.size() >= deepest_inclusion)
    problems_.fail(where, "files are included more than " + std::to_string(deepest_inclusion) + " deep", "",
                   "include them from one file");
  auto [path, content] = find(name, where);
  if (std::ranges::any_of(files_, [&](const auto& file) { return file->path == path; }))
    problems_.fail(where, "'" + to_string(name) + "' includes itself", "files must not include one another in a circle",
                   "remove one of the *INCLUDE lines");
  const int index = problems_.add_file(path);
  if (index > most_files) problems_.fail(where, "more than " + std::to_string(most_files) + " files are included");
  files_.push_back(std::make_unique<File>(File{path, std::move(content), 0, index, 0}));
}

}  // namespace kalfem::abaqus
