// Matrix Market exchange format, [BPR96]: a banner "%%MatrixMarket matrix <coordinate|array> <field> <symmetry>",
// comments, the size, then the entries; indices count from 1, arrays run down the columns.

#include "kalfem/formats/matrices/entries.hpp"
#include "kalfem/formats/matrices/readers.hpp"

namespace kalfem {
namespace {

using Words = std::vector<std::string_view>;

/// Some programs write one percent sign instead of two.
bool is_banner(std::string_view word) {
  const std::string lower = lower_case(word);
  return lower == "%%matrixmarket" || lower == "%matrixmarket";
}

class MarketReader {
public:
  MarketReader(std::string_view text, const std::string& source) : lines_(text), bytes_(text.size()), source_(source) {}

  ForeignMatrix read() {
    read_banner();
    const Words size = next_words();
    if (size.size() != (coordinate_ ? 3u : 2u))
      refuse("the size line holds " + std::to_string(size.size()) + " numbers",
             coordinate_ ? "rows, columns and entries are needed" : "rows and columns are needed");
    rows_ = whole(size[0]);
    columns_ = whole(size[1]);
    MatrixEntries entries(source_, name_from(source_), rows_, columns_, bytes_, lines_.number());
    if (coordinate_) {
      read_coordinates(entries, whole(size[2]));
    } else {
      read_array(entries);
    }
    if (!next_words().empty()) refuse("there are more entries than the size line announces", "one of them is wrong");
    return entries.finish(storage_);
  }

private:
  void read_banner() {
    const auto first = lines_.next();
    const Words words = first ? number_words(*first) : Words{};
    if (words.size() < 5 || !is_banner(words[0]) || lower_case(words[1]) != "matrix")
      refuse("this is no Matrix Market file", "it begins with %%MatrixMarket matrix, a format, a field and a symmetry");
    const std::string format = lower_case(words[2]), field = lower_case(words[3]), symmetry = lower_case(words[4]);
    if (format != "coordinate" && format != "array")
      refuse("the format '" + format + "' is not known", "it is 'coordinate' or 'array'");
    if (field == "complex")
      refuse("the matrix is complex", "the structures here are real", "write stiffness and damping as real matrices");
    if (field == "pattern") refuse("the matrix is a pattern without values", "its entries are needed");
    if (field != "real" && field != "integer" && field != "double")
      refuse("the field '" + field + "' is not known", "it is 'real' or 'integer'");
    coordinate_ = format == "coordinate";
    if (symmetry == "general")
      storage_ = Storage::full;
    else if (symmetry == "symmetric" || symmetry == "hermitian")
      storage_ = Storage::one_triangle;
    else if (symmetry == "skew-symmetric")
      storage_ = Storage::skew_triangle;
    else
      refuse("the symmetry '" + symmetry + "' is not known", "it is 'general', 'symmetric' or 'skew-symmetric'");
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
               "every entry is a row, a column and a value");
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
            refuse("the file ends in column " + std::to_string(column + 1), "every entry of an array is given");
        }
        entries.add(row, column, number(words[used++]), lines_.number());
      }
    }
    if (used < words.size()) refuse("there are more entries than the size line announces", "one of them is wrong");
  }

  std::int64_t whole(std::string_view word) const {
    const auto value = whole_number(word);
    if (!value) refuse("'" + std::string(word.substr(0, 40)) + "' is no whole number", "a size or an index is needed");
    return *value;
  }

  double number(std::string_view word) const {
    const auto value = fortran_number(word);
    if (!value) refuse("'" + std::string(word.substr(0, 40)) + "' is no number", "a value is needed");
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

}  // namespace kalfem
