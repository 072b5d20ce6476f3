// SPDX-License-Identifier: Apache-2.0
// OUTPUT4 as text: a header line (columns, rows, form, type, name, format of the numbers), then for each column that is
// not empty a line (column, first row, words) and its numbers in fields of the given width; first row 0: strings of
// non-zeros follow, each with a header line (row + 65536 (words + 1), or words + 1 and row). A column beyond the last
// ends the matrix.
// OUTPUT4 as Fortran's unformatted records (a length of 4 bytes before and behind each): a header of four integers and
// the name, then a record for each column that is not empty: column, first row, words, numbers; first row 0: strings of
// non-zeros, each behind its header. A column beyond the last ends the matrix. Integers have 4 bytes, or 8 where the
// header has 48; the numbers of single precision then have 8 as well.

#include "kalfem/formats/matrices/single_formats.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>

#include "kalfem/formats/matrices/entries.hpp"

namespace kalfem {

void check_op4(const Op4Header& header, const std::string& source, int line) {
  if (header.type == 3 || header.type == 4)
    refuse_matrix(source, line, "matrix '" + header.name + "' is complex", "only real matrices are supported",
                  "export stiffness and damping as real matrices");
  if (header.type != 1 && header.type != 2)
    refuse_matrix(source, line, "matrix '" + header.name + "' has type " + std::to_string(header.type),
                  "it must be 1 or 2 (real)");
  constexpr std::int64_t not_stated = 0, square = 1, rectangular = 2, diagonal = 3, symmetric = 6, identity = 8;
  for (const auto form : {not_stated, square, rectangular, diagonal, symmetric, identity})
    if (header.form == form) return;
  refuse_matrix(source, line, "matrix '" + header.name + "' has form " + std::to_string(header.form),
                "it must be 1 (square), 2 (rectangular), 3 (diagonal), 6 (symmetric) or 8 (identity)",
                "export the matrix itself, not its factors");
}

MatrixEntries op4_entries(const Op4Header& header, const std::string& source, std::size_t bytes, int line) {
  check_op4(header, source, line);
  if (header.rows == INT64_MIN)
    refuse_matrix(source, line, "the size of a matrix is not a number of rows", "the file is damaged");
  return {source, header.name, std::abs(header.rows), header.columns, bytes, line};
}

// What the form says about the stored columns: of a symmetric matrix one triangle or both may stand, a diagonal one is
// a column, an identity may have no entries at all.
ForeignMatrix op4_matrix(const Op4Header& header, const MatrixEntries& entries) {
  constexpr std::int64_t diagonal = 3, symmetric = 6, identity = 8;
  ForeignMatrix matrix = entries.finish(header.form == symmetric ? Storage::triangle_or_full : Storage::full);
  if (header.form == diagonal && matrix.matrix.cols() == 1) {
    SparseMatrix spread(matrix.matrix.rows(), matrix.matrix.rows());
    spread.reserve(Eigen::VectorXi::Ones(spread.cols()));
    for (SparseMatrix::InnerIterator it(matrix.matrix, 0); it; ++it) spread.insert(it.row(), it.row()) = it.value();
    spread.makeCompressed();
    matrix.matrix = spread;
  }
  if (header.form == identity && matrix.matrix.rows() == matrix.matrix.cols()) matrix.matrix.setIdentity();
  matrix.symmetric = header.form == symmetric || header.form == diagonal || header.form == identity;
  return matrix;
}

namespace {

std::string_view blankless(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

std::string_view cut(std::string_view text, std::size_t begin, std::size_t width) {
  return begin < text.size() ? blankless(text.substr(begin, width)) : std::string_view{};
}

struct NumberFields {
  std::size_t per_line = 5, width = 16;
};

struct TextHeader {
  Op4Header matrix;
  NumberFields fields;
};

/// "1P,3E23.16" or "5E16.9": numbers a line and their width; nothing where it is neither.
std::optional<NumberFields> number_fields(std::string_view format) {
  std::string text = lower_case(format);
  if (const std::size_t comma = text.find(','); comma != std::string::npos) text.erase(0, comma + 1);
  const std::size_t letter = text.find_first_of("edfg");
  if (letter == std::string::npos) return {};
  const auto count = whole_number(std::string_view(text).substr(0, letter));
  const std::size_t dot = std::min(text.find('.', letter), text.size());
  const auto width = whole_number(std::string_view(text).substr(letter + 1, dot - letter - 1));
  if (!count || !width || *count < 1 || *width < 1 || *count > 1000 || *width > 60) return {};
  return NumberFields{static_cast<std::size_t>(*count), static_cast<std::size_t>(*width)};
}

// A header has fixed fields of 8 characters: columns, rows, form, type, name and the format of numbers, "1P,3E23.16".
// With |I16 at its end the two sizes have 16 characters. Without a format, 5E16.9 holds.
std::optional<TextHeader> header_of(std::string_view line) {
  const bool wide = blankless(line).ends_with("|I16");
  const std::size_t size_width = wide ? 16 : 8, form_at = 2 * size_width;
  const auto columns = whole_number(cut(line, 0, size_width)), rows = whole_number(cut(line, size_width, size_width));
  const auto form = whole_number(cut(line, form_at, 8)), type = whole_number(cut(line, form_at + 8, 8));
  if (!columns || !rows || !form || !type) return {};
  TextHeader header{{*columns, *rows, *form, *type, std::string(cut(line, form_at + 16, 8))}, {}};
  std::string_view format = cut(line, form_at + 24, 40);
  if (wide) format.remove_suffix(4);
  if (format.empty()) return header;
  const auto fields = number_fields(format);
  if (!fields) return {};
  header.fields = *fields;
  return header;
}

// Header, then columns until one beyond the last; within a column either one run of numbers or strings of non-zeros.
class TextReader {
public:
  TextReader(std::string_view text, const std::string& source) : lines_(text), bytes_(text.size()), source_(source) {}

  std::vector<ForeignMatrix> read() {
    std::vector<ForeignMatrix> matrices;
    while (const auto line = lines_.next()) {
      if (blankless(*line).empty()) continue;
      const auto header = header_of(*line);
      if (!header)
        refuse("the line is not a header of an OUTPUT4 matrix",
               "columns, rows, form, type, name and a format are expected");
      matrices.push_back(read_matrix(*header, matrices.size()));
    }
    if (matrices.empty()) refuse("the file has no matrix", "an OUTPUT4 file is expected");
    return matrices;
  }

private:
  ForeignMatrix read_matrix(TextHeader header, std::size_t before) {
    if (header.matrix.name.empty()) header.matrix.name = "matrix" + std::to_string(before + 1);
    MatrixEntries entries = op4_entries(header.matrix, source_, bytes_, lines_.number());
    for (auto column = column_header(); column[0] <= header.matrix.columns; column = column_header()) {
      if (column[1] > 0)
        read_numbers(entries, header, column[1] - 1, column[0] - 1, column[2]);
      else
        read_strings(entries, header, column[0] - 1, column[2]);
    }
    next_line();  // the last column holds one number without meaning
    return op4_matrix(header.matrix, entries);
  }

  // Numbers may fill their fields of 8 without a blank between them, so the fields are cut where they are not three
  // words.
  std::array<std::int64_t, 3> column_header() {
    const std::string_view line = next_line();
    std::array<std::int64_t, 3> numbers{};
    const auto words = number_words(line);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto value = whole_number(words.size() == 3 ? words[i] : cut(line, 8 * i, 8));
      if (!value) refuse("the line is not a header of a column", "column, first row and number of words are expected");
      numbers[i] = *value;
    }
    if (numbers[0] < 1 || numbers[1] < 0 || numbers[2] < 0)
      refuse("the header of a column holds a number that is too small", "columns and rows count from 1");
    return numbers;
  }

  // Counts words down to the end of the column. A string's header counts as one word in the short form and as two in
  // the long form, and a value as two words in double precision.
  void read_strings(MatrixEntries& entries, const TextHeader& header, std::int64_t column, std::int64_t words) {
    const std::int64_t words_per_value = header.matrix.type == 1 ? 1 : 2;
    while (words > 0) {
      const auto numbers = number_words(next_line());
      const auto first = numbers.empty() ? std::nullopt : whole_number(numbers[0]);
      const auto second = numbers.size() < 2 ? std::nullopt : whole_number(numbers[1]);
      if (!first || numbers.size() > 2 || (numbers.size() == 2 && !second))
        refuse("the line is not a header of a string of non-zeros", "one or two whole numbers are expected");
      const Op4String string = second ? Op4String{*second - 1, *first - 1} : op4_short_string(*first);
      if (string.words < 1 || string.row < 0) refuse("a string of non-zeros is empty", "it needs a row and a length");
      words -= string.words + (second ? 2 : 1);
      read_numbers(entries, header, string.row, column, string.words / words_per_value);
    }
  }

  void read_numbers(MatrixEntries& entries, const TextHeader& header, std::int64_t row, std::int64_t column,
                    std::int64_t count) {
    std::string_view line;
    for (std::int64_t i = 0; i < count; ++i) {
      const std::size_t place = static_cast<std::size_t>(i) % header.fields.per_line;
      if (place == 0) line = next_line();
      const std::string_view field = cut(line, place * header.fields.width, header.fields.width);
      const auto value = fortran_number(field);
      if (!value)
        refuse("'" + std::string(field) + "' is not a number",
               "an entry of matrix '" + header.matrix.name + "' is expected");
      entries.add(row + i, column, *value, lines_.number());
    }
    const std::size_t used = count > 0 ? static_cast<std::size_t>((count - 1) % fields_per_line(header)) + 1 : 0;
    if (const auto rest = cut(line, used * header.fields.width, line.size()); !rest.empty())
      refuse("'" + std::string(rest.substr(0, 40)) + "' stands behind the last number of a column or string",
             "its header states " + std::to_string(count) + " numbers");
  }

  static std::int64_t fields_per_line(const TextHeader& header) {
    return static_cast<std::int64_t>(header.fields.per_line);
  }

  std::string_view next_line() {
    const auto line = lines_.next();
    if (!line) refuse("the file ends inside a matrix", "it is truncated or damaged", "export the file again");
    return *line;
  }

  [[noreturn]] void refuse(std::string what, std::string why, std::string fix = {}) const {
    refuse_matrix(source_, lines_.number(), std::move(what), std::move(why), std::move(fix));
  }

  LineReader lines_;
  std::size_t bytes_;
  const std::string& source_;
};

}  // namespace

bool looks_like_op4_text(std::string_view text) {
  LineReader lines(text);
  const auto line = lines.next();
  const auto header = line ? header_of(*line) : std::nullopt;
  return header && !header->matrix.name.empty() && header->matrix.columns > 0;
}

std::vector<ForeignMatrix> parse_op4_text(std::string_view text, const std::string& source) {
  return TextReader(text, source).read();
}

namespace {

constexpr std::int32_t short_header = 24, long_header = 48;

// Fortran's first record has the length of a header before and behind it in one order of bytes only. This tells
// OUTPUT4 from other files, and its order of bytes.
/// Whether the first record is a header in this order of bytes.
bool begins_with_header(std::string_view bytes, bool big_endian) {
  if (bytes.size() < 8) return false;
  const auto length = value_at<std::int32_t>(bytes.data(), big_endian);
  if (length != short_header && length != long_header) return false;
  const std::size_t behind = 4 + static_cast<std::size_t>(length);
  return bytes.size() >= behind + 4 && value_at<std::int32_t>(bytes.data() + behind, big_endian) == length;
}

// The same from Fortran records. A record whose two lengths differ is not read on: everything behind it would be noise.
class BinaryReader {
public:
  BinaryReader(std::string_view bytes, const std::string& source, bool big_endian)
      : file_(bytes, source, big_endian),
        long_words_(value_at<std::int32_t>(bytes.data(), big_endian) == long_header) {}

  std::vector<ForeignMatrix> read() {
    std::vector<ForeignMatrix> matrices;
    while (!file_.at_end()) matrices.push_back(read_matrix(matrices.size()));
    return matrices;
  }

private:
  ForeignMatrix read_matrix(std::size_t before) {
    ByteReader record = next_record();
    Op4Header header;
    header.columns = whole(record);
    header.rows = whole(record);
    header.form = whole(record);
    header.type = whole(record);
    header.name = name_in(record.take(record.remaining()), before);
    MatrixEntries entries = op4_entries(header, file_.file(), file_.size(), 0);
    std::size_t behind = 0;
    for (;;) {
      ByteReader column = next_record();
      const std::int64_t number = whole(column), row = whole(column), words = whole(column);
      if (number > header.columns) break;
      if (number < 1 || row < 0 || words < 0) column.refuse("the header of a column holds a number that is too small");
      if (row > 0)
        read_numbers(entries, column, header, row - 1, number - 1, words / words_per_value(header));
      else
        read_strings(entries, column, header, number - 1, words);
      behind += column.remaining();
    }
    ForeignMatrix matrix = op4_matrix(header, entries);
    if (behind > 0)
      matrix.notes.push_back(std::to_string(behind) + " bytes behind the numbers of its columns are not used");
    return matrix;
  }

  /// Letters and digits of the name; blanks and zeros fill it up.
  [[nodiscard]] static std::string name_in(std::string_view bytes, std::size_t before) {
    std::string name;
    for (const char c : bytes)
      if (c > ' ' && c < '\x7f') name += c;
    return name.empty() ? "matrix" + std::to_string(before + 1) : name;
  }

  void read_strings(MatrixEntries& entries, ByteReader& record, const Op4Header& header, std::int64_t column,
                    std::int64_t words) const {
    const bool long_strings = header.rows < 0 || header.rows >= 65536;
    while (words > 0) {
      const std::int64_t first = whole(record);
      const Op4String string = long_strings ? Op4String{whole(record) - 1, first - 1} : op4_short_string(first);
      if (string.words < 1 || string.row < 0) record.refuse("a string of non-zeros is empty");
      words -= string.words + (long_strings ? 2 : 1);
      read_numbers(entries, record, header, string.row, column, string.words / words_per_value(header));
    }
  }

  void read_numbers(MatrixEntries& entries, ByteReader& record, const Op4Header& header, std::int64_t row,
                    std::int64_t column, std::int64_t count) const {
    const bool single = header.type == 1 && !long_words_;
    for (std::int64_t i = 0; i < count; ++i)
      entries.add(row + i, column, single ? static_cast<double>(record.read<float>()) : record.read<double>());
  }

  [[nodiscard]] std::int64_t words_per_value(const Op4Header& header) const {
    return header.type == 2 && !long_words_ ? 2 : 1;
  }

  std::int64_t whole(ByteReader& record) const {
    return long_words_ ? record.read<std::int64_t>() : record.read<std::int32_t>();
  }

  ByteReader next_record() {
    const auto length = file_.read<std::int32_t>();
    if (length < 0) file_.refuse("a record has a negative length");
    const std::string_view content = file_.take(static_cast<std::size_t>(length));
    if (file_.read<std::int32_t>() != length) file_.refuse("the lengths before and after a record differ");
    return {content, file_.file(), file_.big_endian()};
  }

  ByteReader file_;
  bool long_words_;
};

}  // namespace

bool looks_like_op4_binary(std::string_view bytes) {
  return begins_with_header(bytes, false) || begins_with_header(bytes, true);
}

std::vector<ForeignMatrix> parse_op4_binary(std::string_view bytes, const std::string& source) {
  if (!looks_like_op4_binary(bytes))
    refuse_matrix(source, 0, "this is not a binary OUTPUT4 file", "its first record must have 24 or 48 bytes");
  return BinaryReader(bytes, source, begins_with_header(bytes, true)).read();
}

}  // namespace kalfem
