#include "kalfem/formats/nastran/card_stream.hpp"

#include <algorithm>
#include <utility>

#include "kalfem/formats/gmsh/gmsh_scanner.hpp"
#include "kalfem/formats/nastran/card.hpp"
#include "kalfem/formats/tables/text_table.hpp"

namespace kalfem::nastran {
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
