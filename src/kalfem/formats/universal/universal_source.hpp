#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

/// A line "    -1" with at most the six columns of the format, which opens and closes a dataset. A number -1 in a
/// column of samples stands further to the right.
bool is_universal_mark(std::string_view line);

/// Lines and bytes of a universal file, one after the other: the file is never held as a whole.
class UniversalSource {
public:
  /// Throws InvalidInput where the file cannot be read.
  explicit UniversalSource(const std::filesystem::path& file);

  /// Moves on to the next line, without its end. False where the file ends.
  bool next();
  /// The next next() returns this line again.
  void put_back() { again_ = true; }
  [[nodiscard]] const std::string& line() const { return line_; }
  [[nodiscard]] int number() const { return number_; }  ///< of the line, from 1
  [[nodiscard]] SourceLocation place() const { return {file_, number_}; }
  /// A problem of this line.
  [[nodiscard]] InvalidInput problem(std::string what, std::string why = {}, std::string fix = {}) const;

  /// Bytes after the current line.
  [[nodiscard]] std::uint64_t bytes_left();
  /// Whether so many bytes further on an end mark stands, after line breaks and blanks or at once, or the file ends.
  bool mark_follows(std::uint64_t bytes);
  /// Takes bytes, which may hold anything. There must be so many.
  std::string take(std::uint64_t bytes);

private:
  std::ifstream stream_;
  std::string file_, line_;
  std::uint64_t size_ = 0;
  int number_ = 0;
  bool again_ = false;
};

}  // namespace kalfem
