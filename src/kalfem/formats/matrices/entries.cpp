// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/matrices/entries.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/model/finite_element_model.hpp"

namespace kalfem {
namespace {

/// Empty rows are cheap to write down, but a dimension beyond both of these is a damaged file, not a structure.
constexpr std::int64_t believable_dimension = 1'000'000;

/// Whether a_ij and a_ji both stand in the matrix for some i != j.
bool holds_a_pair_twice(const SparseMatrix& matrix, const SparseMatrix& transposed) {
  for (Eigen::Index column = 0; column < matrix.outerSize(); ++column) {
    SparseMatrix::InnerIterator one(matrix, column), other(transposed, column);
    while (one && other) {
      if (one.row() == other.row() && one.row() != column) return true;
      const auto row = std::min(one.row(), other.row());
      if (one.row() == row) ++one;
      if (other && other.row() == row) ++other;
    }
  }
  return false;
}

SparseMatrix diagonal_part(const SparseMatrix& matrix) {
  SparseMatrix diagonal = matrix;
  diagonal.prune([](Eigen::Index row, Eigen::Index column, double) { return row == column; });
  return diagonal;
}

}  // namespace

void refuse_matrix(const std::string& file, int line, std::string what, std::string why, std::string fix) {
  throw InvalidInput(Issue{{file, line}, std::move(what), std::move(why), std::move(fix)});
}

// The text is rewritten for the C++ parser: D becomes e, and an exponent without a letter ("1.5-3") gets one.
std::optional<double> fortran_number(std::string_view text) {
  if (text.starts_with("+-")) return {};
  if (text.starts_with('+')) text.remove_prefix(1);
  if (text.empty() || text.size() > 60) return {};
  char buffer[64];
  std::size_t size = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == 'd' || c == 'D') {
      buffer[size++] = 'e';
    } else if ((c == '+' || c == '-') && i > 0 &&
               (std::isdigit(static_cast<unsigned char>(text[i - 1])) || text[i - 1] == '.')) {
      buffer[size++] = 'e';
      if (c == '-') buffer[size++] = c;
    } else if ((c == '+' || c == '-') && i > 0 && (text[i - 1] == '+' || text[i - 1] == '-')) {
      return {};
    } else if (c != '+' || i == 0) {
      buffer[size++] = c;
    }
    if (size > 60) return {};
  }
  double value = 0.0;
  const auto [end, error] = std::from_chars(buffer, buffer + size, value);
  if (end != buffer + size) return {};
  if (error == std::errc::result_out_of_range) {
    // A number below the smallest one is 0, one above the largest is not finite.
    const auto exponent = std::find(buffer, buffer + size, 'e');
    const bool tiny = exponent + 1 < buffer + size && exponent[1] == '-';
    return tiny ? 0.0 : std::numeric_limits<double>::infinity();
  }
  if (error != std::errc()) return {};
  return value;
}

// Some codes write integers as reals: "12." and "12.0" are whole numbers here.
std::optional<std::int64_t> whole_number(std::string_view text) {
  if (text.starts_with("+-")) return {};
  if (text.starts_with('+')) text.remove_prefix(1);
  std::int64_t value = 0;
  const char* const end = text.data() + text.size();
  auto [rest, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc()) return {};
  if (rest != end && *rest == '.') ++rest;
  while (rest != end && *rest == '0') ++rest;
  if (rest != end) return {};
  return value;
}

std::vector<std::string_view> number_words(std::string_view line) {
  constexpr std::string_view separators = " \t,;\r\f\v";
  std::vector<std::string_view> words;
  for (std::size_t begin = line.find_first_not_of(separators); begin != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(separators, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(separators, end);
  }
  return words;
}

std::optional<std::string_view> LineReader::next() {
  if (rest_.empty()) return {};
  const std::size_t end = std::min(rest_.find('\n'), rest_.size());
  std::string_view line = rest_.substr(0, end);
  rest_.remove_prefix(std::min(end + 1, rest_.size()));
  if (line.ends_with('\r')) line.remove_suffix(1);
  ++number_;
  return line;
}

// Checks the size before anything is allocated, against the bytes of the file and the 32 bits of an index.
MatrixEntries::MatrixEntries(std::string file, std::string name, std::int64_t rows, std::int64_t columns,
                             std::size_t bytes, int line)
    : file_(std::move(file)), name_(std::move(name)), rows_(rows), columns_(columns) {
  const std::int64_t most =
      std::min<std::int64_t>(std::max<std::int64_t>(believable_dimension, static_cast<std::int64_t>(bytes)),
                             std::numeric_limits<std::int32_t>::max() - 1);
  if (rows < 1 || columns < 1 || rows > most || columns > most)
    refuse(line,
           "matrix '" + name_ + "' has " + std::to_string(rows) + " rows and " + std::to_string(columns) + " columns",
           "a matrix needs both, and a file of " + std::to_string(bytes) + " bytes is too small for it",
           "the file is damaged; export it again");
}

void MatrixEntries::refuse(int line, std::string what, std::string why, std::string fix) const {
  refuse_matrix(file_, line, std::move(what), std::move(why), std::move(fix));
}

std::string MatrixEntries::place(std::int64_t row, std::int64_t column) const {
  return "entry (" + std::to_string(row + 1) + ", " + std::to_string(column + 1) + ") of matrix '" + name_ + "'";
}

// Entries are checked one by one while the line is known, so that a message can name it.
void MatrixEntries::add(std::int64_t row, std::int64_t column, double value, int line) {
  if (row < 0 || column < 0 || row >= rows_ || column >= columns_)
    refuse(line, place(row, column) + " is out of range",
           "the matrix has " + std::to_string(rows_) + " rows and " + std::to_string(columns_) + " columns",
           "export the file again or correct its header");
  if (!std::isfinite(value))
    refuse(line, place(row, column) + " is not finite", "every entry must be a finite number",
           "check why the other code wrote it");
  entries_.emplace_back(static_cast<std::int32_t>(row), static_cast<std::int32_t>(column), value);
}

// An entry that stands twice is refused: some codes mean the sum, others the last one. The search for it runs only if
// the assembly met one.
SparseMatrix MatrixEntries::assembled() const {
  SparseMatrix matrix(rows_, columns_);
  bool repeated = false;
  matrix.setFromTriplets(entries_.begin(), entries_.end(), [&](double first, double) {
    repeated = true;
    return first;
  });
  if (!repeated) return matrix;
  auto sorted = entries_;
  const auto key = [](const auto& entry) { return std::pair(entry.col(), entry.row()); };
  std::ranges::sort(sorted, {}, key);
  const auto twice = std::ranges::adjacent_find(sorted, {}, key);
  refuse(0, place(twice->row(), twice->col()) + " is defined twice", "it is not clear which one applies",
         "write every entry once");
}

// A file with one triangle is completed to both, A + A^T - diag(A), after a look whether some pair stands twice: then
// the file is not what it says, or (where it may be either) it is full already.
ForeignMatrix MatrixEntries::finish(Storage storage) const {
  SparseMatrix matrix = assembled();
  bool symmetric = false;
  if (storage != Storage::full && rows_ == columns_) {
    const SparseMatrix transposed = matrix.transpose();
    const bool twice = holds_a_pair_twice(matrix, transposed);
    if (twice && storage != Storage::triangle_or_full)
      refuse(0, "matrix '" + name_ + "' has both entries of a symmetric pair",
             "its file states that only one triangle is given", "write one triangle or declare the matrix general");
    if (storage == Storage::skew_triangle) {
      matrix = SparseMatrix(matrix - transposed);
    } else if (!twice) {
      matrix = SparseMatrix(matrix + transposed - diagonal_part(matrix));
      symmetric = true;
    }
  } else if (storage == Storage::one_triangle || storage == Storage::skew_triangle) {
    refuse(0, "matrix '" + name_ + "' is declared symmetric but is not square",
           "only a square matrix can be symmetric");
  }
  matrix.prune([](Eigen::Index, Eigen::Index, double value) { return value != 0.0; });
  matrix.makeCompressed();
  return {name_, std::move(matrix), {}, symmetric};
}

void NodalEntries::add(const MatrixDof& row, const MatrixDof& column, double value, int line) {
  entries_.push_back({row, column, value, line});
}

// The rows of the matrix are the degrees of freedom that were met, in the order of node and direction.
ForeignMatrix NodalEntries::finish(Storage storage, std::size_t bytes) const {
  std::vector<MatrixDof> dofs;
  dofs.reserve(2 * entries_.size());
  for (const auto& entry : entries_) dofs.insert(dofs.end(), {entry.row, entry.column});
  std::ranges::sort(dofs);
  dofs.erase(std::unique(dofs.begin(), dofs.end()), dofs.end());
  const auto place = [&](const MatrixDof& dof) { return std::ranges::lower_bound(dofs, dof) - dofs.begin(); };
  const auto n = static_cast<std::int64_t>(dofs.size());
  MatrixEntries numbered(file_, name_, n, n, bytes);
  for (const auto& entry : entries_) numbered.add(place(entry.row), place(entry.column), entry.value, entry.line);
  ForeignMatrix matrix = numbered.finish(storage);
  matrix.dofs = std::move(dofs);
  return matrix;
}

std::string to_string(const MatrixDof& dof) {
  const std::string copy = dof.copy > 0 ? "#" + std::to_string(dof.copy) : "";
  if (dof.direction < 0) return "q" + std::to_string(dof.node) + copy;
  return std::to_string(dof.node) + copy + "." + direction_names[static_cast<std::size_t>(std::min(dof.direction, 5))];
}

}  // namespace kalfem
