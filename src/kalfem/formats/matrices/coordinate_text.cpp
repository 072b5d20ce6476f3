// SPDX-License-Identifier: Apache-2.0
// Matrix Market exchange format, [BPR96]: a banner "%%MatrixMarket matrix <coordinate|array> <field> <symmetry>",
// comments, the size, then the entries; indices count from 1, arrays run down the columns.
// "row column value", indices from 1: what CalculiX stores with *FREQUENCY, SOLVER=MATRIXSTORAGE and Abaqus with
// *MATRIX OUTPUT, FORMAT=COORDINATE. The size is the largest index.
// "node, direction, node, direction, value" as *MATRIX INPUT of Abaqus and the substructures of CalculiX have it, alone
// in a file (*MATRIX OUTPUT) or below keyword lines that name the matrix.

#include <algorithm>

#include "kalfem/formats/matrices/entries.hpp"
#include "kalfem/formats/matrices/single_formats.hpp"

namespace kalfem {
namespace {

using Words = std::vector<std::string_view>;

/// Some programs write one percent sign instead of two.
bool is_banner(std::string_view word) {
  const std::string lower = lower_case(word);
  return lower == "%%matrixmarket" || lower == "%matrixmarket";
}

// Banner, size line, entries. Coordinates stand one a line; the values of an array may be spread over lines at will.
// Entries beyond those that the size announces mean that the size or the entries are wrong, so they are refused.
class MarketReader {
public:
  MarketReader(std::string_view text, const std::string& source) : lines_(text), bytes_(text.size()), source_(source) {}

  ForeignMatrix read() {
    read_banner();
    const Words size = next_words();
    if (size.size() != (coordinate_ ? 3u : 2u))
      refuse("the size line has " + std::to_string(size.size()) + " numbers",
             coordinate_ ? "rows, columns and entries are expected" : "rows and columns are expected");
    rows_ = whole(size[0]);
    columns_ = whole(size[1]);
    MatrixEntries entries(source_, name_from(source_), rows_, columns_, bytes_, lines_.number());
    if (coordinate_) {
      read_coordinates(entries, whole(size[2]));
    } else {
      read_array(entries);
    }
    if (!next_words().empty())
      refuse("there are more entries than the size line states", "either the size line or the entries are wrong");
    return entries.finish(storage_);
  }

private:
  // Only the first line decides how the entries are read. "hermitian" is the same as "symmetric" for real matrices.
  void read_banner() {
    const auto first = lines_.next();
    const Words words = first ? number_words(*first) : Words{};
    if (words.size() < 5 || !is_banner(words[0]) || lower_case(words[1]) != "matrix")
      refuse("this is not a Matrix Market file",
             "it must begin with %%MatrixMarket matrix, a format, a field and a symmetry");
    if (words.size() > 5)
      refuse("the first line goes on with '" + std::string(words[5].substr(0, 40)) + "'",
             "nothing follows the symmetry", "remove it, or make it a comment of its own");
    const std::string format = lower_case(words[2]), field = lower_case(words[3]), symmetry = lower_case(words[4]);
    if (format != "coordinate" && format != "array")
      refuse("the format '" + format + "' is not known", "it must be 'coordinate' or 'array'");
    if (field == "complex")
      refuse("the matrix is complex", "only real matrices are supported",
             "export stiffness and damping as real matrices");
    if (field == "pattern") refuse("the matrix is a pattern without values", "its entries are missing");
    if (field != "real" && field != "integer" && field != "double")
      refuse("the field '" + field + "' is not known", "it must be 'real' or 'integer'");
    coordinate_ = format == "coordinate";
    if (symmetry == "general")
      storage_ = Storage::full;
    else if (symmetry == "symmetric" || symmetry == "hermitian")
      storage_ = Storage::one_triangle;
    else if (symmetry == "skew-symmetric")
      storage_ = Storage::skew_triangle;
    else
      refuse("the symmetry '" + symmetry + "' is not known", "it must be 'general', 'symmetric' or 'skew-symmetric'");
  }

  /// Words of the next line that holds some and is no comment; none at the end.
  Words next_words() {
    while (const auto line = lines_.next()) {
      if (line->starts_with('%')) continue;
      Words words = number_words(*line);
      if (!words.empty()) return words;
    }
    return {};
  }

  void read_coordinates(MatrixEntries& entries, std::int64_t count) {
    for (std::int64_t i = 0; i < count; ++i) {
      const Words words = next_words();
      if (words.size() != 3)
        refuse(words.empty() ? "the file ends after " + std::to_string(i) + " of " + std::to_string(count) + " entries"
                             : "an entry has " + std::to_string(words.size()) + " numbers",
               "every entry needs a row, a column and a value");
      entries.add(whole(words[0]) - 1, whole(words[1]) - 1, number(words[2]), lines_.number());
    }
  }

  /// Down the columns; a symmetric one from the diagonal on, a skew-symmetric one from below it.
  void read_array(MatrixEntries& entries) {
    Words words;
    std::size_t used = 0;
    for (std::int64_t column = 0; column < columns_; ++column) {
      const std::int64_t first = storage_ == Storage::full           ? 0
                                 : storage_ == Storage::one_triangle ? column
                                                                     : column + 1;
      for (std::int64_t row = first; row < rows_; ++row) {
        if (used == words.size()) {
          words = next_words();
          used = 0;
          if (words.empty())
            refuse("the file ends in column " + std::to_string(column + 1), "an array needs every entry");
        }
        entries.add(row, column, number(words[used++]), lines_.number());
      }
    }
    if (used < words.size())
      refuse("there are more entries than the size line states", "either the size line or the entries are wrong");
  }

  std::int64_t whole(std::string_view word) const {
    const auto value = whole_number(word);
    if (!value)
      refuse("'" + std::string(word.substr(0, 40)) + "' is not a whole number", "a size or an index is expected here");
    return *value;
  }

  double number(std::string_view word) const {
    const auto value = fortran_number(word);
    if (!value) refuse("'" + std::string(word.substr(0, 40)) + "' is not a number", "a value is expected here");
    return *value;
  }

  [[noreturn]] void refuse(std::string what, std::string why, std::string fix = {}) const {
    refuse_matrix(source_, lines_.number(), std::move(what), std::move(why), std::move(fix));
  }

  LineReader lines_;
  std::size_t bytes_;
  const std::string& source_;
  bool coordinate_ = true;
  Storage storage_ = Storage::full;
  std::int64_t rows_ = 0, columns_ = 0;
};

}  // namespace

std::vector<ForeignMatrix> parse_matrix_market(std::string_view text, const std::string& source) {
  return {MarketReader(text, source).read()};
}

// The size is not stated, so entries are collected first. Whether they are one triangle or the full matrix is not
// stated either: MatrixEntries decides by the entries that it gets.
std::vector<ForeignMatrix> parse_triplets(std::string_view text, const std::string& source) {
  struct Entry {
    std::int64_t row, column;
    double value;
    int line;
  };
  std::vector<Entry> entries;
  std::int64_t size = 0;
  LineReader lines(text);
  while (const auto line = lines.next()) {
    const auto words = number_words(*line);
    if (words.empty() || words[0].starts_with('#') || words[0].starts_with('%') || words[0].starts_with("**")) continue;
    const auto row = whole_number(words[0]);
    const auto column = words.size() == 3 ? whole_number(words[1]) : std::nullopt;
    const auto value = words.size() == 3 ? fortran_number(words[2]) : std::nullopt;
    if (!row || !column || !value)
      refuse_matrix(source, lines.number(), "the line is not an entry of a matrix",
                    "a row, a column and a value are expected");
    if (*row < 1 || *column < 1)
      refuse_matrix(source, lines.number(), "an index is below 1", "rows and columns count from 1");
    size = std::max({size, *row, *column});
    entries.push_back({*row - 1, *column - 1, *value, lines.number()});
  }
  if (entries.empty())
    refuse_matrix(source, 0, "the file has no matrix entries", "a row, a column and a value are expected");
  MatrixEntries matrix(source, name_from(source), size, size, text.size());
  for (const auto& entry : entries) matrix.add(entry.row, entry.column, entry.value, entry.line);
  return {matrix.finish(Storage::triangle_or_full)};
}

std::optional<std::string> unknown_parameter(std::string_view line, std::initializer_list<std::string_view> known) {
  std::string text = lower_case(line);
  std::erase_if(text, [](char c) { return c == ' ' || c == '\t' || c == '\r'; });
  for (std::size_t at = text.find(','); at != std::string::npos; at = text.find(',', at + 1)) {
    const std::string parameter = text.substr(at + 1, text.find(',', at + 1) - at - 1);
    const std::string name = parameter.substr(0, parameter.find('='));
    if (!name.empty() && std::ranges::find(known, name) == known.end()) return name;
  }
  return std::nullopt;
}

namespace {

/// Value of a parameter of a keyword line in lower case, "" where it has none of that name.
std::string parameter(std::string_view line, const std::string& name) {
  std::string text = lower_case(line);
  std::erase_if(text, [](char c) { return c == ' ' || c == '\t'; });
  const std::size_t at = text.find("," + name + "=");
  if (at == std::string::npos) return {};
  const std::size_t begin = at + name.size() + 2;
  return text.substr(begin, text.find(',', begin) - begin);
}

// Lines of five numbers, gathered by degree of freedom; a keyword line ends one matrix and names the next.
// The name is that of NAME=, otherwise of TYPE= or MATRIX=. A negative node number is an internal node, mostly of
// Lagrange multipliers. They make the matrix indefinite and are refused.
class NodalReader {
public:
  NodalReader(std::string_view text, const std::string& source) : lines_(text), bytes_(text.size()), source_(source) {}

  std::vector<ForeignMatrix> read() {
    while (const auto line = lines_.next()) {
      if (line->starts_with("**")) continue;
      if (line->starts_with('*')) {
        begin(*line);
        continue;
      }
      const auto words = number_words(*line);
      if (words.empty() || words[0].starts_with('#') || words[0].starts_with('%')) continue;
      add(words);
    }
    finish();
    if (matrices_.empty())
      refuse("the file has no matrix entries", "node, direction, node, direction and value are expected");
    return std::move(matrices_);
  }

private:
  // SCALE FACTOR multiplies every entry. TYPE=UNSYMMETRIC states that both triangles are there. INPUT= refers to
  // another file, which is then the one to read.
  void begin(std::string_view keyword) {
    finish();
    if (const auto other = unknown_parameter(keyword, {"name", "type", "matrix", "scalefactor", "input"}))
      refuse("the parameter '" + *other + "' of a matrix is not known", "what it means for the entries is not either",
             "known are NAME, TYPE, MATRIX, SCALE FACTOR and INPUT");
    name_ = parameter(keyword, "name");
    if (name_.empty()) name_ = parameter(keyword, "type");
    if (name_.empty()) name_ = parameter(keyword, "matrix");
    unsymmetric_ = parameter(keyword, "type") == "unsymmetric";
    if (unsymmetric_ && name_ == "unsymmetric") name_.clear();
    const std::string scale = parameter(keyword, "scalefactor");
    const auto factor = scale.empty() ? std::optional<double>(1.0) : fortran_number(scale);
    if (!factor)
      refuse("the scale factor '" + scale.substr(0, 40) + "' is not a number",
             "every entry is multiplied by this factor");
    factor_ = *factor;
    if (!parameter(keyword, "input").empty())
      refuse("the entries are in another file", "INPUT= names it", "read that file");
  }

  void add(const std::vector<std::string_view>& words) {
    if (words.size() != 5)
      refuse("the line holds " + std::to_string(words.size()) + " numbers",
             "an entry needs node, direction, node, direction and value");
    const MatrixDof row = dof(words[0], words[1]), column = dof(words[2], words[3]);
    const auto value = fortran_number(words[4]);
    if (!value) refuse("'" + std::string(words[4].substr(0, 40)) + "' is not a number", "a value is expected here");
    if (!entries_) entries_.emplace(source_, name_.empty() ? name_from(source_) : name_);
    entries_->add(row, column, factor_ * *value, lines_.number());
  }

  [[nodiscard]] MatrixDof dof(std::string_view node, std::string_view direction) const {
    const auto number = whole_number(node), axis = whole_number(direction);
    if (!number || !axis || *axis < 0 || *axis > 6)
      refuse("'" + std::string(node.substr(0, 40)) + ", " + std::string(direction.substr(0, 40)) +
                 "' is not a degree of freedom",
             "a node number and a direction are expected: 1 ... 6, or 0 for a generalised coordinate");
    if (*number < 0)
      refuse("the matrix has the internal node " + std::to_string(*number), "Lagrange multipliers make it indefinite",
             "export it without the constraints, or condense it to retained nodes in the other code");
    // Node 0 has generalised coordinates too: the direction counts them.
    if (*number == 0) return {*axis, -1};
    return {*number, static_cast<int>(*axis) - 1};
  }

  void finish() {
    if (entries_)
      matrices_.push_back(entries_->finish(unsymmetric_ ? Storage::full : Storage::triangle_or_full, bytes_));
    entries_.reset();
  }

  [[noreturn]] void refuse(std::string what, std::string why, std::string fix = {}) const {
    refuse_matrix(source_, lines_.number(), std::move(what), std::move(why), std::move(fix));
  }

  LineReader lines_;
  std::size_t bytes_;
  const std::string& source_;
  std::vector<ForeignMatrix> matrices_;
  std::optional<NodalEntries> entries_;
  std::string name_;
  bool unsymmetric_ = false;
  double factor_ = 1.0;
};

}  // namespace

std::vector<ForeignMatrix> parse_nodal(std::string_view text, const std::string& source) {
  return NodalReader(text, source).read();
}

}  // namespace kalfem
