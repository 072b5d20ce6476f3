// "row column value", indices from 1: what CalculiX stores with *FREQUENCY, SOLVER=MATRIXSTORAGE and Abaqus with
// *MATRIX OUTPUT, FORMAT=COORDINATE. The size is the largest index.

#include <algorithm>

#include "kalfem/formats/matrices/entries.hpp"
#include "kalfem/formats/matrices/readers.hpp"

namespace kalfem {

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
      refuse_matrix(source, lines.number(), "the line is no entry of a matrix",
                    "a row, a column and a value are needed");
    if (*row < 1 || *column < 1)
      refuse_matrix(source, lines.number(), "an index is below 1", "rows and columns count from 1");
    size = std::max({size, *row, *column});
    entries.push_back({*row - 1, *column - 1, *value, lines.number()});
  }
  if (entries.empty())
    refuse_matrix(source, 0, "the file holds no entry of a matrix", "a row, a column and a value are needed");
  MatrixEntries matrix(source, name_from(source), size, size, text.size());
  for (const auto& entry : entries) matrix.add(entry.row, entry.column, entry.value, entry.line);
  return {matrix.finish(Storage::triangle_or_full)};
}

}  // namespace kalfem
