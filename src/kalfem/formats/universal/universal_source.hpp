// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/mapped_file.hpp"

namespace kalfem {

/// A line "    -1" with at most the six columns of the format, which opens and closes a dataset. A number -1 in a
/// column of samples stands further to the right.
bool is_universal_mark(std::string_view line);

/// Lines and bytes of a universal file, one after the other. The file stays on the disk.
class UniversalSource {
public:
  /// Throws InvalidInput where the file cannot be read.
  explicit UniversalSource(const std::filesystem::path& file);
  /// The same of text in memory; `name` stands for the file in messages.
  UniversalSource(std::string content, std::string name);

  /// Moves on to the next line, without its end. False where the file ends. Throws InvalidInput where the line is
  /// longer than `longest_line`.
  bool next();
  /// Goes back before the first line.
  void rewind();
  /// The next next() returns this line again.
  void put_back() { again_ = true; }
  [[nodiscard]] const std::string& line() const { return line_; }
  [[nodiscard]] int number() const { return number_; }  ///< of the line, from 1
  /// Whether the file ends within the current line.
  [[nodiscard]] bool is_cut_off() const { return cut_off_; }
  [[nodiscard]] SourceLocation place() const { return {file_, number_}; }
  /// A problem of this line.
  [[nodiscard]] InvalidInput problem(std::string what, std::string why = {}, std::string fix = {}) const;

  /// Bytes after the current line.
  [[nodiscard]] std::uint64_t bytes_left() const { return bytes_.size() - at_; }
  /// Whether so many bytes further on an end mark stands, after line breaks and blanks or at once.
  [[nodiscard]] bool mark_follows(std::uint64_t bytes) const;
  /// Takes bytes, which may hold anything. There must be so many.
  std::string take(std::uint64_t bytes);

private:
  std::unique_ptr<const MappedFile> mapped_;
  std::unique_ptr<const std::string> content_;  ///< of text in memory
  std::string_view bytes_;                      ///< all
  std::size_t at_ = 0;                          ///< behind the current line
  std::string file_, line_;
  int number_ = 0;
  bool again_ = false, cut_off_ = false;
};

}  // namespace kalfem
