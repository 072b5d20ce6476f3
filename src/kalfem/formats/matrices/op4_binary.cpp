// OUTPUT4 as Fortran's unformatted records (a length of 4 bytes before and behind each): a header of four integers and
// the name, then a record for each column that is not empty: column, first row, words, numbers; first row 0: strings of
// non-zeros, each behind its header. A column beyond the last ends the matrix. Integers have 4 bytes, or 8 where the
// header has 48; the numbers of single precision then have 8 as well.

#include "kalfem/formats/matrices/bytes.hpp"
#include "kalfem/formats/matrices/op4.hpp"
#include "kalfem/formats/matrices/readers.hpp"

namespace kalfem {
namespace {

constexpr std::int32_t short_header = 24, long_header = 48;

/// Whether the first record is a header in this order of bytes.
bool begins_with_header(std::string_view bytes, bool big_endian) {
  if (bytes.size() < 8) return false;
  const auto length = value_at<std::int32_t>(bytes.data(), big_endian);
  if (length != short_header && length != long_header) return false;
  const std::size_t behind = 4 + static_cast<std::size_t>(length);
  return bytes.size() >= behind + 4 && value_at<std::int32_t>(bytes.data() + behind, big_endian) == length;
}

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
    for (;;) {
      ByteReader column = next_record();
      const std::int64_t number = whole(column), row = whole(column), words = whole(column);
      if (number > header.columns) break;
      if (number < 1 || row < 0 || words < 0) column.refuse("the header of a column holds a number that is too small");
      if (row > 0)
        read_numbers(entries, column, header, row - 1, number - 1, words / words_per_value(header));
      else
        read_strings(entries, column, header, number - 1, words);
    }
    return op4_matrix(header, entries);
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
    if (file_.read<std::int32_t>() != length) file_.refuse("the lengths before and behind a record differ");
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
    refuse_matrix(source, 0, "this is no binary OUTPUT4 file", "its first record has 24 or 48 bytes");
  return BinaryReader(bytes, source, begins_with_header(bytes, true)).read();
}

}  // namespace kalfem
