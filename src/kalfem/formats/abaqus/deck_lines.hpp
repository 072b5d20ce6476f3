// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/abaqus.hpp"

namespace kalfem::abaqus {

/// A place in one of a deck's files.
struct Where {
  int file = 0;  ///< in the order of their first opening
  int line = 0;  ///< 1-based
};

/// The files of a deck and the problems found in them; the twentieth ends the reading.
class Problems {
public:
  int add_file(const std::string& name);
  [[nodiscard]] const std::string& file(int index) const { return files_[static_cast<std::size_t>(index)]; }
  [[nodiscard]] SourceLocation location(const Where& where) const { return {file(where.file), where.line}; }

  /// Notes a problem and goes on, unless there are too many.
  void add(const Where& where, std::string what, std::string why = {}, std::string fix = {});
  /// Notes a problem and stops here.
  [[noreturn]] void fail(const Where& where, std::string what, std::string why = {}, std::string fix = {});
  /// Throws InvalidInput when there was any.
  void raise() const { issues_.raise(); }
  [[nodiscard]] bool empty() const { return issues_.empty(); }

private:
  std::vector<std::string> files_;
  IssueList issues_;
};

/// A keyword line: "*SHELL SECTION, ELSET=skin, MATERIAL=al".
struct Keyword {
  struct Parameter {
    std::string name, value;     ///< the name like the keyword's; the value as it stands
    mutable bool asked = false;  ///< the reader looked at it, see settle_ledger()
  };
  std::string name;   ///< capitals without blanks: SHELLSECTION
  std::string title;  ///< for messages: "*SHELL SECTION"
  std::vector<Parameter> parameters;
  Where where;

  [[nodiscard]] bool has(std::string_view parameter) const;
  /// Value of a parameter, "" where it is absent or has none.
  [[nodiscard]] std::string get(std::string_view parameter) const;
  /// The value in capitals without blanks, for words of the format.
  [[nodiscard]] std::string word(std::string_view parameter) const;
};

/// Takes a keyword line apart. `line` begins with its asterisk.
Keyword parse_keyword(std::string_view line, const Where& where);

/// The lines of a deck from front to back, without comments and with included files in their places.
class DeckLines {
public:
  DeckLines(std::string content, const std::string& source, const DeckLoader& loader, Problems& problems);

  /// The next keyword; data lines before it are passed over. False at the end of the deck.
  bool next_keyword(Keyword& keyword);
  /// The next data line of the present keyword; false where another keyword or the end follows. It is valid until the
  /// next call.
  bool next_data(std::string_view& line);
  /// The same, with blank lines: they stand for defaults under some keywords.
  bool next_data_or_blank(std::string_view& line);
  /// A data line that ends its file without a line end, and whether the file is the deck itself.
  struct OpenEnd {
    Where where;
    bool in_deck_itself = false;
  };
  [[nodiscard]] const std::vector<OpenEnd>& open_ends() const { return open_ends_; }
  /// Place of the line that was given last.
  [[nodiscard]] const Where& where() const { return where_; }
  /// Puts the content of a file before the next line (the parameter INPUT of some keywords).
  void insert(const std::string& name, const Where& where);
  /// A file beside the present one, or beside the deck itself.
  [[nodiscard]] std::string load(const std::string& name, const Where& where);

private:
  struct File {
    std::string path;
    std::string content;
    std::size_t at = 0;
    int index = 0;
    int line = 0;
  };
  enum class Kind { data, blank, keyword, end };

  struct Loaded {
    std::string path, content;
  };
  Loaded find(const std::string& name, const Where& where);
  Kind peek();
  bool read_line();
  std::string joined_keyword();
  bool follow_include();

  const DeckLoader& loader_;
  Problems& problems_;
  std::vector<std::unique_ptr<File>> files_;
  std::unique_ptr<File> closed_;  ///< its last line may still be in use
  std::string_view line_;
  bool pending_ = false;  ///< line_ has been read and not been given
  std::vector<OpenEnd> open_ends_;
  Where where_, line_where_;
};

}  // namespace kalfem::abaqus
