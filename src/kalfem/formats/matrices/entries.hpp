// SPDX-License-Identifier: Apache-2.0
// Inside of the readers of matrices and of universal files only.

// Inside of the readers of binary files only.

#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kalfem/base/text.hpp"
#include "kalfem/formats/matrices.hpp"

namespace kalfem {

/// Throws InvalidInput about one place of a file; line 0: the file has no lines.
[[noreturn]] void refuse_matrix(const std::string& file, int line, std::string what, std::string why,
                                std::string fix = {});

/// A number as Fortran or C writes it: "1.5", "+1.5D+03", "1.5+3"; nothing where the text is not one.
std::optional<double> fortran_number(std::string_view text);

/// A whole number, also as "12." or "12.0"; nothing where the text is not one.
std::optional<std::int64_t> whole_number(std::string_view text);

/// Words of a line that are separated by blanks, tabs or commas. Nothing stands between two commas without an empty
/// word.
std::vector<std::string_view> number_words(std::string_view line);

/// Lines of a text one after the other, without their ends.
class LineReader {
public:
  explicit LineReader(std::string_view text) : rest_(text) {}
  /// The next line, nothing at the end.
  std::optional<std::string_view> next();
  [[nodiscard]] int number() const { return number_; }  ///< of the line that was read last, from 1

private:
  std::string_view rest_;
  int number_ = 0;
};

/// Which entries of a symmetric matrix a file holds.
enum class Storage {
  full,             ///< every entry stands in the file
  one_triangle,     ///< a pair (i, j), (j, i) stands once, in either place
  skew_triangle,    ///< the same, with a_ji = -a_ij
  triangle_or_full  ///< one triangle where no pair stands twice
};

/// Collects the entries of one matrix and checks each: in range, finite.
class MatrixEntries {
public:
  /// `bytes`: size of the file, which bounds the dimensions it can mean. Throws where they are negative or larger.
  MatrixEntries(std::string file, std::string name, std::int64_t rows, std::int64_t columns, std::size_t bytes,
                int line = 0);

  /// Entry with the position from 0; `line` is where it stands.
  void add(std::int64_t row, std::int64_t column, double value, int line = 0);

  /// The matrix, zeros dropped. Throws where an entry stands twice.
  [[nodiscard]] ForeignMatrix finish(Storage storage) const;

private:
  [[noreturn]] void refuse(int line, std::string what, std::string why, std::string fix = {}) const;
  [[nodiscard]] SparseMatrix assembled() const;
  [[nodiscard]] std::string place(std::int64_t row, std::int64_t column) const;

  std::string file_, name_;
  std::int64_t rows_, columns_;
  std::vector<Eigen::Triplet<double, std::int32_t>> entries_;
};

/// Entries between degrees of freedom that are met one by one; rows and columns are numbered when the matrix is
/// finished, by node and direction.
class NodalEntries {
public:
  NodalEntries(std::string file, std::string name) : file_(std::move(file)), name_(std::move(name)) {}
  void add(const MatrixDof& row, const MatrixDof& column, double value, int line);
  [[nodiscard]] ForeignMatrix finish(Storage storage, std::size_t bytes) const;

private:
  struct Entry {
    MatrixDof row, column;
    double value;
    int line;
  };
  std::string file_, name_;
  std::vector<Entry> entries_;
};

/// "12.x", "12#2.x" for its second copy, or "q3" for a generalised coordinate.
std::string to_string(const MatrixDof& dof);

/// The value that begins at `bytes`, in the given order of bytes.
template <typename T>
T value_at(const char* bytes, bool big_endian) {
  char ordered[sizeof(T)];
  std::memcpy(ordered, bytes, sizeof(T));
  if (big_endian != (std::endian::native == std::endian::big)) std::reverse(ordered, ordered + sizeof(T));
  T value;
  std::memcpy(&value, ordered, sizeof(T));
  return value;
}

/// Reads a binary file value by value and never beyond its end.
class ByteReader {
public:
  ByteReader(std::string_view bytes, std::string file, bool big_endian)
      : bytes_(bytes), file_(std::move(file)), big_endian_(big_endian) {}

  template <typename T>
  T read() {
    return value_at<T>(take(sizeof(T)).data(), big_endian_);
  }

  std::string_view take(std::size_t count) {
    if (count > remaining()) refuse("the file ends, but " + std::to_string(count) + " more bytes are expected");
    const std::string_view taken = bytes_.substr(position_, count);
    position_ += count;
    return taken;
  }

  void go_to(std::size_t position) {
    if (position > bytes_.size())
      refuse("the file ends before byte " + std::to_string(position) + " that it refers to");
    position_ = position;
  }

  [[nodiscard]] std::size_t position() const { return position_; }
  [[nodiscard]] std::size_t remaining() const { return bytes_.size() - position_; }
  [[nodiscard]] std::size_t size() const { return bytes_.size(); }
  [[nodiscard]] bool at_end() const { return remaining() == 0; }
  [[nodiscard]] bool big_endian() const { return big_endian_; }
  [[nodiscard]] const std::string& file() const { return file_; }

  [[noreturn]] void refuse(std::string what, std::string why = "the file is truncated or damaged",
                           std::string fix = "export the file again") const {
    refuse_matrix(file_, 0, std::move(what) + " (at byte " + std::to_string(position_) + ")", std::move(why),
                  std::move(fix));
  }

private:
  std::string_view bytes_;
  std::string file_;
  bool big_endian_;
  std::size_t position_ = 0;
};

}  // namespace kalfem
