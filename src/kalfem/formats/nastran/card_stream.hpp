// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/nastran/card.hpp"

namespace kalfem::nastran {

/// The files of a deck by position, and the problems found in them, of which the first 20 are kept.
class DeckFiles {
public:
  std::int32_t add(const std::string& name);
  [[nodiscard]] SourceLocation location(const Place& place) const;
  void problem(const Place& place, const std::string& what, const std::string& why = {}, const std::string& fix = {});
  /// One whose quotations are names of files, which are shown; other words of an included file are not.
  void problem_with_name(const Place& place, const std::string& what, const std::string& why, const std::string& fix);
  void problem(const Place& place, const CardError& error) { problem(place, error.what(), error.why(), error.fix()); }
  /// The deck ends here without its ENDDATA, which may be the cause of other problems and is told with them.
  void set_open_end(const Place& place) { open_end_ = place; }
  [[nodiscard]] bool sound() const { return count_ == 0; }
  /// Throws InvalidInput when there was any problem.
  void raise() const;

private:
  std::vector<std::string> names_;
  IssueList listed_;
  std::size_t count_ = 0;
  std::optional<Place> open_end_;
};

/// Content of an included file; throws InvalidInput where it cannot be read.
using IncludeLoader = std::function<std::string(const std::filesystem::path&)>;

/// One line without comment and blanks at its end.
struct DeckLine {
  std::string_view text;
  Place place;
};

/// The lines of a deck with INCLUDEs put in their places. Names of included files are relative to the file that
/// includes, or else to the first file; a name in quotes may run over several lines. Texts live as long as the object.
class DeckLines {
public:
  DeckLines(std::string content, const std::string& source, IncludeLoader loader, DeckFiles& files);
  /// The next line that is not empty, nothing at the end.
  std::optional<DeckLine> next();
  /// Content of the file that the deck begins with.
  [[nodiscard]] std::string_view main_text() const { return texts_.front(); }
  /// Text of a file by its position among those that were opened.
  [[nodiscard]] const std::string& text(std::int32_t file) const { return texts_[static_cast<std::size_t>(file)]; }
  /// File and offset of a part of a text; nothing of what is no part of one, as a field of a line with tabs.
  [[nodiscard]] std::optional<std::pair<std::int32_t, std::size_t>> place_of(std::string_view part) const;
  /// Last lines of included files that have no line end, as those of files that are cut off.
  [[nodiscard]] const std::vector<Place>& open_ends() const { return open_ends_; }

private:
  struct Open {
    std::filesystem::path path;
    std::string_view rest;
    Place place;
  };
  void open(std::string content, const std::filesystem::path& path);
  std::optional<std::string_view> raw_line();
  void include(std::string_view statement, const Place& place);

  IncludeLoader loader_;
  DeckFiles& files_;
  std::deque<std::string> texts_;
  std::vector<Open> stack_;
  std::vector<Place> open_ends_;
  std::size_t opened_ = 0;
};

/// Puts cards together from lines of the bulk data: small field (8 columns), large field (16 columns, '*' behind the
/// name or in the first column) and free field (commas), mixed at will, tabs as to the next multiple of 8 columns.
///
/// A line goes on with the card before it where its first field is blank or begins with '+' or '*'. A named marker
/// (+ABC) whose card stands elsewhere is found by its name, whatever its case and first character; other markers, and
/// none, mean the next line. Lines that begin with '=' are images of the card before, see replication.hpp. Cards of
/// free text, as DEQATN, are handed over without fields.
class CardStream {
public:
  using Sink = std::function<void(const Card&)>;
  CardStream(DeckFiles& files, Sink sink) : files_(files), sink_(std::move(sink)) {}

  void line(const DeckLine& line);
  /// Hands over what is left: the last card, and those whose continuations stand elsewhere.
  void finish();

private:
  struct Continuation {
    std::vector<std::string_view> fields;
    std::string marker;  ///< name of the one that the next line bears
    Place place;
  };
  struct Line : Continuation {
    std::string_view first;  ///< name, or marker of a continuation
    bool large = false;
    bool continues = false;
  };
  Line split(const DeckLine& line);
  void split_free(std::string_view text, Line& line);
  static void split_fixed(std::string_view text, Line& line);
  void start_text(const DeckLine& text);
  void replicate(const Line& line);
  void start(const Line& line);
  void set_aside(Line& line);
  void append(std::vector<std::string_view>& fields, const Line& line);
  void end_card();
  void hand_over(Card& card);

  DeckFiles& files_;
  Sink sink_;
  std::deque<std::string> expanded_;  ///< lines with tabs
  Card card_;
  bool has_card_ = false;
  bool in_text_ = false;                                ///< of a card of free text
  std::string marker_;                                  ///< of the line before
  Continuation* orphan_ = nullptr;                      ///< the continuation set aside that following lines belong to
  std::vector<std::pair<Card, std::string>> deferred_;  ///< with the marker that they ask for
  std::set<std::string> asked_;                         ///< names of those markers
  std::map<std::string, Continuation> orphans_;         ///< by name
  std::vector<std::string> steps_;                      ///< of the replication before
  std::vector<std::string> image_;                      ///< fields of the present card, if it is an image
  std::size_t images_ = 0;
};

}  // namespace kalfem::nastran
