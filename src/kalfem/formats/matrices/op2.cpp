// SPDX-License-Identifier: Apache-2.0
// Matrix data blocks of a Nastran OUTPUT2 file. Everything stands in Fortran's unformatted records. A record of one
// integer is a key: the number of words of the record behind it where it is positive, the end of a logical record where
// it is negative, the end of a data block where it is 0. A data block is
//     2, name, -1, 7, trailer, -2, 1, 0, k, name and more, -3, 1, kind, ...
// kind 0 is a table, which is passed over; of a matrix every column follows as strings of non-zeros
//     words, (first row, numbers), ..., 0 or a negative key, 1, 1 where a column follows.
// The trailer holds number, columns, rows, form and type. Words have 4 or 8 bytes.

#include <algorithm>

#include "kalfem/formats/matrices/entries.hpp"
#include "kalfem/formats/matrices/single_formats.hpp"

namespace kalfem {
namespace {

/// Whether the first record is a key of this length and order of bytes.
bool begins_with_key(std::string_view bytes, std::size_t word, bool big_endian) {
  return bytes.size() >= 8 + word &&
         value_at<std::int32_t>(bytes.data(), big_endian) == static_cast<std::int32_t>(word) &&
         value_at<std::int32_t>(bytes.data() + 4 + word, big_endian) == static_cast<std::int32_t>(word);
}

bool is_big_endian(std::string_view bytes) {
  return begins_with_key(bytes, 4, true) || begins_with_key(bytes, 8, true);
}

class Op2Reader {
public:
  Op2Reader(std::string_view bytes, const std::string& source, bool big_endian, std::size_t word)
      : file_(bytes, source, big_endian), word_(word) {}

  std::vector<ForeignMatrix> read() {
    std::vector<ForeignMatrix> matrices;
    std::int64_t key = read_key();
    if (key == 3) key = pass_over_label();
    for (; key != 0; key = file_.at_end() ? 0 : read_key()) read_block(key, matrices);
    if (matrices.empty())
      file_.refuse("the file has no matrix, only tables", "matrices such as KAA and MAA are required",
                   "export them with OUTPUT2 from the other code");
    if (!tables_.empty()) matrices.front().notes.push_back("tables that are not used: " + tables_);
    if (!file_.at_end())
      matrices.front().notes.push_back(std::to_string(file_.remaining()) +
                                       " bytes behind the end of the data blocks are not used");
    return matrices;
  }

private:
  // Files written with a label start with the key 3, the date, and two character records before the first data block.
  /// The date and two names at the beginning of many files; returns the key that follows.
  std::int64_t pass_over_label() {
    next_record();
    for (int i = 0; i < 2; ++i) {
      read_key();
      next_record();
    }
    read_key();  // -1
    read_key();  // 0
    return file_.at_end() ? 0 : read_key();
  }

  void read_block(std::int64_t key, std::vector<ForeignMatrix>& matrices) {
    if (key < 0) file_.refuse("a data block begins with the key " + std::to_string(key));
    Op4Header header;
    header.name = name_in(next_record());
    read_key();
    read_key();
    ByteReader trailer(next_record(), file_.file(), file_.big_endian());
    whole(trailer);
    header.columns = whole(trailer);
    header.rows = whole(trailer);
    header.form = whole(trailer);
    header.type = whole(trailer);
    for (int i = 0; i < 4; ++i) read_key();
    next_record();
    read_key();
    read_key();
    if (const std::int64_t kind = read_key(); kind == 0) {
      pass_over_table();
      tables_ += (tables_.empty() ? "" : ", ") + header.name;
    } else {
      matrices.push_back(read_matrix(header));
      if (!file_.at_end()) read_key();  // the 0 that ends the block
    }
  }

  void pass_over_table() {
    for (std::int64_t key = read_key(); key != 0; key = read_key()) {
      for (; key > 0; key = read_key()) next_record();
      read_key();
      read_key();
      if (file_.at_end()) return;
    }
  }

  // One column after the other, each as strings of non-zeros until a key that is not positive; then a 1 announces the
  // next column.
  ForeignMatrix read_matrix(const Op4Header& header) {
    MatrixEntries entries = op4_entries(header, file_.file(), file_.size(), 0);
    const bool single = header.type == 1 && word_ == 4;
    const std::size_t bytes = single ? 4 : 8;
    std::int64_t column = 0;
    for (std::int64_t more = 1; more > 0; ++column) {
      for (std::int64_t key = read_key(); key > 0; key = read_key()) {
        ByteReader record(next_record(), file_.file(), file_.big_endian());
        std::int64_t row = whole(record) - 1;
        for (; record.remaining() >= bytes; ++row)
          entries.add(row, column, single ? static_cast<double>(record.read<float>()) : record.read<double>());
        if (!record.at_end()) record.refuse("a string of numbers has a part of a number at its end");
      }
      read_key();
      more = read_key();
    }
    if (column > header.columns)
      file_.refuse("matrix '" + header.name + "' has " + std::to_string(column) + " columns, its trailer says " +
                   std::to_string(header.columns));
    return op4_matrix(header, entries);
  }

  [[nodiscard]] static std::string name_in(std::string_view bytes) {
    std::string name;
    for (const char c : bytes)
      if (std::isalnum(static_cast<unsigned char>(c)) || c == '_') name += c;
    return name.empty() ? "matrix" : name;
  }

  std::int64_t whole(ByteReader& record) const {
    return word_ == 8 ? record.read<std::int64_t>() : record.read<std::int32_t>();
  }

  std::int64_t read_key() {
    ByteReader record(next_record(), file_.file(), file_.big_endian());
    if (record.size() != word_)
      file_.refuse("a record of " + std::to_string(record.size()) + " bytes stands where a key of " +
                   std::to_string(word_) + " is expected");
    return whole(record);
  }

  std::string_view next_record() {
    const auto length = file_.read<std::int32_t>();
    if (length < 0) file_.refuse("a record has a negative length");
    const std::string_view content = file_.take(static_cast<std::size_t>(length));
    if (file_.read<std::int32_t>() != length) file_.refuse("the lengths before and after a record differ");
    return content;
  }

  ByteReader file_;
  std::size_t word_;
  std::string tables_;  ///< names of those that were passed over
};

}  // namespace

bool looks_like_op2(std::string_view bytes) {
  return begins_with_key(bytes, 4, false) || begins_with_key(bytes, 8, false) || is_big_endian(bytes);
}

std::vector<ForeignMatrix> parse_op2(std::string_view bytes, const std::string& source) {
  if (!looks_like_op2(bytes))
    refuse_matrix(source, 0, "this is not an OUTPUT2 file", "it must begin with a record of one integer");
  const bool big = is_big_endian(bytes);
  const std::size_t word = begins_with_key(bytes, 8, big) ? 8 : 4;
  return Op2Reader(bytes, source, big, word).read();
}

}  // namespace kalfem
