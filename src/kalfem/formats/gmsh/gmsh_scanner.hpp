// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "kalfem/formats/tables/text_table.hpp"

namespace kalfem {

/// What a message can show of a word that may be binary rubbish: at most 40 printable characters.
std::string printable(std::string_view word);

/// The content of a Gmsh file, read from front to back as lines of text or as numbers, which stand as words in an ASCII
/// file and as bytes in a binary one. Whatever cannot be read throws InvalidInput with its line or byte.
class GmshScanner {
public:
  /// `source` names the file in messages.
  GmshScanner(std::string content, const std::string& source) : text_(std::move(content)), problems_(source) {}

  /// From here on numbers are bytes, and places are told as bytes.
  void set_binary() { binary_ = true; }
  [[nodiscard]] bool binary() const { return binary_; }

  /// Skips blanks and line ends; true when nothing is left.
  bool at_end();
  /// Whether the text goes on with this word, behind blanks and line ends.
  bool next_is(std::string_view word);
  /// The rest of the line without blanks around it; steps over its end.
  std::string_view line();
  /// Where the next number begins.
  std::size_t start();

  std::int64_t text_integer(const char* what);  ///< as a word, in binary files too
  std::int64_t int32(const char* what);         ///< as a word or 4 bytes
  std::int64_t int64(const char* what);         ///< as a word or 8 bytes
  double real(const char* what);                ///< as a word or 8 bytes; not checked to be finite

  /// Throws unless so many items (each of that many words or bytes at least) can stand in the rest of the file.
  std::int64_t check_count(std::int64_t count, const char* items, std::size_t start, std::size_t words,
                           std::size_t bytes);
  /// Throws unless what began at `start` is the whole of its line in an ASCII file.
  void end_record(std::size_t start, const char* what);
  void end_section(std::string_view name);
  void skip_section(std::string_view name, std::size_t start);

  /// A position of the file: its line, or only the file where it is binary.
  [[nodiscard]] SourceLocation place(std::size_t position);

  /// Notes a problem at a position of the file and goes on.
  void note(std::size_t position, const std::string& what, const std::string& why = {}, const std::string& fix = {});
  /// Throws when a problem was noted.
  void raise() const { problems_.raise(); }
  [[noreturn]] void fail(std::size_t position, const std::string& what, const std::string& why = {},
                         const std::string& fix = {});

private:
  void skip_blanks();
  std::string_view word(const char* what);
  template <typename Number>
  Number bytes(const char* what);
  int line_of(std::size_t position);

  std::string text_;
  std::size_t at_ = 0;
  bool binary_ = false;
  FileProblems problems_;
  std::size_t counted_to_ = 0;  ///< line ends before this position are counted
  int lines_ = 1;
};

}  // namespace kalfem
