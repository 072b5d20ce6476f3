#include "kalfem/formats/nastran/card_stream.hpp"

#include <algorithm>
#include <utility>

#include "kalfem/formats/gmsh/gmsh_scanner.hpp"
#include "kalfem/formats/nastran/card.hpp"
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
  if (++count_ > most_told) return;
  const bool included = place.file > 0;
  listed_.add(location(place), included ? without_quotations(what) : what, included ? without_quotations(why) : why,
              fix);
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
  const std::string title = "INCLUDE '" + name + "'";
  if (name.empty()) return files_.problem(place, "INCLUDE without a file name", "", "name it");
  if (!loader_)
    return files_.problem(place, title + " cannot be followed", "this deck is read without access to other files");
  const auto path = (stack_.back().path.parent_path() / name).lexically_normal();
  if (std::ranges::any_of(stack_, [&](const Open& file) { return file.path.lexically_normal() == path; }))
    return files_.problem(place, title + ": the file includes itself", "the inclusion would never end",
                          "remove the INCLUDE");
  if (stack_.size() >= deepest_include || opened_ >= most_includes)
    return files_.problem(place, title + " is nested more than " + std::to_string(deepest_include) +
                                     " levels deep, or there are more than " + std::to_string(most_includes));
  try {
    open(loader_(path), path);
  } catch (const InvalidInput& error) {
    files_.problem(place, title + ": '" + path.string() + "' cannot be read", "the deck continues in that file",
                   "names are relative to the including file");
  }
}

namespace {

/// A longer card is a mistake: of a file that is no deck.
constexpr std::size_t most_fields = 8'000'000;

/// Tabs as blanks up to the next multiple of 8 columns.
std::string expand_tabs(std::string_view text) {
  std::string line;
  for (const char c : text) {
    if (c != '\t')
      line += c;
    else
      do line += ' ';
      while (line.size() % 8 != 0);
  }
  return line;
}

std::string_view columns(std::string_view text, std::size_t first, std::size_t width) {
  return first < text.size() ? trimmed(text.substr(first, width)) : std::string_view{};
}

/// The name in a marker such as +ABC or *ABC.
std::string_view marker_name(std::string_view marker) { return marker.empty() ? marker : trimmed(marker.substr(1)); }

}  // namespace

// A card and its continuations. Without markers a continuation follows its card at once. With markers it may stand
// anywhere in the deck: it is set aside under its marker, a card that ends with a marker nobody has answered is
// deferred, and finish() joins them.
void CardStream::line(const DeckLine& text) {
  if (trimmed(text.text).starts_with('='))
    return files_.problem(text.place, "a replicated card ('=')", "replication is not supported",
                          "write the cards in full, as in the echo of the bulk data");
  Line line = split(text);
  if (!line.continues) {
    end_card();
    start(line);
    return;
  }
  // A named continuation belongs to the card that asks for it, wherever that stands.
  const auto name = marker_name(line.first), expected = marker_name(marker_);
  if (!name.empty() && name != expected && (!expected.empty() || asked_.contains(name))) {
    end_card();
    set_aside(line);
  } else if (has_card_ && card_.place.file != text.place.file) {
    files_.problem(text.place, "a continuation that begins a file, or follows an INCLUDE",
                   "a card cannot continue in another file", "put the card and its continuations into one file");
  } else if (has_card_ || orphan_ != nullptr) {
    append(has_card_ ? card_.fields : orphan_->fields, line);
    marker_ = line.marker;
    if (orphan_ != nullptr) orphan_->marker = marker_;
  } else {
    files_.problem(text.place, "a continuation ('" + printable(text.text) + "') without a card before it",
                   "a line whose first field is blank or begins with + or * continues a card",
                   "correct the line or the previous one");
  }
}

// A comma anywhere makes the line free-field, otherwise its fields are columns of 8. An asterisk in the first field
// doubles their width. A blank first field, + or * continues the card before.
CardStream::Line CardStream::split(const DeckLine& source) {
  Line line;
  line.place = source.place;
  std::string_view text = source.text;
  if (text.find(',') != std::string_view::npos) {
    split_free(text, line);
  } else {
    if (text.find('\t') != std::string_view::npos) text = expanded_.emplace_back(expand_tabs(text));
    split_fixed(text, line);
  }
  line.continues = line.first.empty() || line.first.front() == '+' || line.first.front() == '*';
  return line;
}

void CardStream::split_fixed(std::string_view text, Line& line) {
  line.first = columns(text, 0, 8);
  line.large = line.first.find('*') != std::string_view::npos;
  const std::size_t width = line.large ? 16 : 8;
  for (std::size_t first = 8; first < std::min<std::size_t>(72, text.size()); first += width)
    line.fields.push_back(columns(text, first, width));
  line.marker = columns(text, 72, 8);
}

/// Up to 8 (4 of a large field) values and a marker; values behind a marker go on with the card.
void CardStream::split_free(std::string_view text, Line& line) {
  std::size_t position = 0, count = 0;
  const auto next = [&] {
    const std::size_t end = std::min(text.find(',', position), text.size());
    const auto field = trimmed(text.substr(position, end - position));
    position = end + 1;
    return field;
  };
  line.first = next();
  line.large = line.first.find('*') != std::string_view::npos;
  const std::size_t per_line = line.large ? 4 : 8;
  while (position <= text.size()) {
    const auto field = next();
    if (count % (per_line + 1) != per_line) {
      line.fields.push_back(field);
    } else {
      line.marker = field;
      const bool is_marker = field.empty() || field.front() == '+' || field.front() == '*';
      if (!is_marker && (position <= text.size() || parse_real(field)))
        files_.problem(line.place, "a card in free field with '" + printable(field) + "' in its tenth field",
                       "that field is reserved for the continuation marker", "begin a new line with a comma or '+,'");
    }
    ++count;
  }
}

void CardStream::start(const Line& line) {
  auto name = line.first;
  while (!name.empty() && (name.back() == '*' || name.back() == ' ')) name.remove_suffix(1);
  card_.name = upper_case(name);
  card_.place = line.place;
  card_.fields.clear();
  has_card_ = true;
  orphan_ = nullptr;
  append(card_.fields, line);
  marker_ = line.marker;
}

void CardStream::set_aside(Line& line) {
  Continuation aside{{}, line.marker, line.place};
  append(aside.fields, line);
  const auto [place, is_new] = orphans_.try_emplace(marker_name(line.first), std::move(aside));
  if (!is_new)
    files_.problem(line.place, "the continuation '" + printable(line.first) + "' appears twice", "it is ambiguous",
                   "give continuations different markers");
  orphan_ = &place->second;
  marker_ = line.marker;
}

/// Values of a line behind those of the lines before. Two lines in large field make one of eight values; where the
/// second is left out its values are blank.
void CardStream::append(std::vector<std::string_view>& fields, const Line& line) {
  const std::size_t width = line.large ? 4 : 8;
  const auto whole = [&](std::size_t size) { return (size + width - 1) / width * width; };
  if (fields.size() + line.fields.size() > most_fields)
    return files_.problem(line.place, "a card of more than " + std::to_string(most_fields) + " fields", "",
                          "correct the file");
  const std::size_t begin = whole(fields.size());
  fields.resize(begin);
  fields.insert(fields.end(), line.fields.begin(), line.fields.end());
  // A line counts in full, also where it is short or holds nothing but its marker.
  fields.resize(begin + whole(std::max<std::size_t>(line.fields.size(), 1)));
}

void CardStream::end_card() {
  if (!std::exchange(has_card_, false)) return;
  const bool asks = !marker_.empty() && (marker_.front() == '+' || marker_.front() == '*') && marker_.size() > 1;
  if (asks && orphan_ == nullptr) {
    deferred_.emplace_back(card_, marker_);
    asked_.insert(marker_name(marker_));
  } else {
    hand_over(card_);
  }
}

void CardStream::hand_over(Card& card) {
  while (!card.fields.empty() && card.fields.back().empty()) card.fields.pop_back();
  sink_(card);
}

// Chains of continuations may be long: each one leads to the next by its own marker, and each is used once. A chain
// that breaks leaves the card short. Continuations that no card asked for are told.
void CardStream::finish() {
  end_card();
  for (auto& [card, marker] : deferred_) {
    while (!marker.empty()) {
      const auto next = orphans_.extract(marker_name(marker));
      if (next.empty()) break;
      const auto& more = next.mapped();
      card.fields.resize((card.fields.size() + 7) / 8 * 8);
      card.fields.insert(card.fields.end(), more.fields.begin(), more.fields.end());
      marker = more.marker;
    }
    hand_over(card);
  }
  for (const auto& [name, orphan] : orphans_)
    files_.problem(orphan.place, "the continuation '" + printable(name) + "' does not belong to a card",
                   "no card ends with this marker", "correct the markers");
  deferred_.clear();
  orphans_.clear();
}

}  // namespace kalfem::nastran
