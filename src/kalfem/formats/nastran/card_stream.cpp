// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/nastran/card_stream.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "kalfem/formats/gmsh/gmsh_scanner.hpp"
#include "kalfem/formats/nastran/replication.hpp"
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

/// The name in a marker such as +ABC or *ABC. The first character counts for nothing, nor does the case.
std::string marker_name(std::string_view marker) {
  return marker.empty() ? std::string() : upper_case(trimmed(marker.substr(1)));
}

/// Numbers of lines, as in punch files, are no markers.
std::string marker_in_tenth_field(std::string_view field) {
  const bool has_sign = field.starts_with('+') || field.starts_with('*');
  return has_sign || !parse_integer(trimmed(field)) ? marker_name(field) : std::string();
}

/// Cards whose fields are formulas or texts, with commas and signs that mean nothing here.
bool is_free_text(std::string_view line) {
  if (std::string_view("DMSUFdmsuf").find(line.front()) == std::string_view::npos) return false;
  const auto name = upper_case(line.substr(0, std::min(line.find_first_of(", \t"), std::size_t{8})));
  constexpr std::array names = {"DEQATN", "MONPNT1", "MONPNT2", "MONPNT3", "MONDSP1", "MONGRP",
                                "MONSUM", "SELABEL", "UDNAME",  "FBODYLD", "FBODYSB", "FRFXIT"};
  return std::ranges::find(names, name) != names.end();
}

bool continues_text(std::string_view line) {
  return line.starts_with(' ') || line.starts_with('\t') || line.starts_with('+') || line.starts_with('*') ||
         line.starts_with(',');
}

}  // namespace

// A card and its continuations. Without markers a continuation follows its card at once. With markers it may stand
// anywhere in the deck: it is set aside under its marker, a card that ends with a marker nobody has answered is
// deferred, and finish() joins them.
void CardStream::line(const DeckLine& text) {
  if (in_text_ && continues_text(text.text)) return;
  in_text_ = is_free_text(text.text);
  if (in_text_) return start_text(text);
  Line line = split(text);
  if (line.first.starts_with('=')) return replicate(line);
  if (!line.continues) {
    end_card();
    start(line);
    return;
  }
  // A named continuation belongs to the card that asks for it, wherever that stands.
  const auto name = marker_name(line.first);
  if (!name.empty() && name != marker_ && (!marker_.empty() || asked_.contains(name))) {
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

/// A card of free text is its name alone.
void CardStream::start_text(const DeckLine& text) {
  Line line;
  line.place = text.place;
  line.first = text.text.substr(0, std::min(text.text.find_first_of(", \t"), std::size_t{8}));
  end_card();
  start(line);
}

// "=" begins the image of the card before, "=(n)" further n images by the steps of the last one.
void CardStream::replicate(const Line& line) {
  const auto problem = [&](const std::string& why) {
    files_.problem(line.place, "a replicated card ('=')", why,
                   "write the card in full, as in the echo of the bulk data");
  };
  if (!has_card_ || card_.fields.size() > 8)
    return problem("it repeats a card of one line, which must stand before it");
  const auto count = image_count(line.first);
  if (!count) return problem("it begins with = or =(n)");
  const bool has_steps = std::ranges::any_of(line.fields, [](std::string_view field) { return !field.empty(); });
  if (has_steps || *count == 0) steps_.assign(line.fields.begin(), line.fields.end());
  if (steps_.empty()) return problem("=(n) repeats the steps of the line before, and there are none");
  images_ += std::max<std::size_t>(*count, 1);
  if (images_ > most_images) return problem("the deck has more than " + std::to_string(most_images) + " of them");
  for (std::size_t i = 0; i < std::max<std::size_t>(*count, 1); ++i) {
    auto image = image_of(card_.fields, steps_);
    if (!image) return problem("*(x) adds to a number, and a field of the card before is none");
    end_card();
    image_.swap(*image);
    card_.place = line.place;
    card_.uses.clear();
    card_.fields.assign(image_.begin(), image_.end());
    has_card_ = true;
    marker_.clear();
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
  if (text.size() > 72) line.marker = marker_in_tenth_field(text.substr(72, 8));
}

/// Up to 8 (4 of a large field) values and a marker; values behind a marker go on with the card.
void CardStream::split_free(std::string_view text, Line& line) {
  std::vector<std::string_view> fields;
  for (std::size_t position = 0; position <= text.size();) {
    const std::size_t end = std::min(text.find(',', position), text.size());
    fields.push_back(trimmed(text.substr(position, end - position)));
    position = end + 1;
  }
  line.first = fields.front();
  line.large = line.first.find('*') != std::string_view::npos;
  const std::size_t per_line = line.large ? 4 : 8;
  const auto last = std::find_if(fields.rbegin(), fields.rend(), [](auto field) { return !field.empty(); });
  const auto filled = static_cast<std::size_t>(fields.rend() - last);  // commas behind the last field add none
  for (std::size_t i = 1; i < fields.size(); ++i) {
    const auto field = fields[i];
    if (i % (per_line + 1) != 0) {
      if (i < filled || i <= per_line) line.fields.push_back(field);
      continue;
    }
    const bool goes_on = i + 1 < filled;
    const bool is_marker = field.empty() || field.front() == '+' || field.front() == '*';
    // Eight values in a row and a ninth number: a list that its writer did not break.
    const auto is_value = [](std::string_view value) { return !value.empty(); };
    const bool is_list = parse_real(field) && std::all_of(line.fields.end() - static_cast<std::ptrdiff_t>(per_line),
                                                          line.fields.end(), is_value);
    if (i >= filled) break;
    if (!is_marker && (goes_on || is_list))
      files_.problem(line.place, "a card in free field with '" + printable(field) + "' in its tenth field",
                     "that field is reserved for the continuation marker", "begin a new line with a comma or '+,'");
    line.marker =
        goes_on ? std::string() : marker_in_tenth_field(is_marker ? std::string(field) : " " + std::string(field));
  }
}

void CardStream::start(const Line& line) {
  auto name = line.first;
  while (!name.empty() && (name.back() == '*' || name.back() == ' ')) name.remove_suffix(1);
  card_.name = upper_case(name);
  card_.place = line.place;
  card_.fields.clear();
  card_.uses.clear();
  steps_.clear();
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
  if (!marker_.empty() && orphan_ == nullptr) {
    deferred_.emplace_back(card_, marker_);
    asked_.insert(marker_);
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
      auto next = orphans_.extract(marker);
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
