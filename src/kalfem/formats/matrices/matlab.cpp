// SPDX-License-Identifier: Apache-2.0
// MATLAB files of the versions 5 to 7 [MAT5]: elements of a tag (type, bytes) and data, padded to 8 bytes; a small
// element has its data in the tag. An array holds flags, dimensions, name and numbers, a sparse one row indices and
// column starts before them. Compressed elements are zlib streams. Arrays of other kinds (cells, structures, text) are
// passed over.

#include <set>

#include "kalfem/formats/matrices/entries.hpp"
#include "kalfem/formats/matrices/single_formats.hpp"
#include "kalfem/formats/text_file.hpp"
#include "kalfem/formats/unpacked_size.hpp"

namespace kalfem {
namespace {

constexpr std::uint32_t array_element = 14, compressed_element = 15;
constexpr int sparse_array = 5, last_number_array = 15;
constexpr std::uint32_t complex_flag = 0x0800;

struct Element {
  std::uint32_t type = 0;
  std::string_view data;
};

// A tag is 8 bytes: type and number of bytes, 4 each. If the upper half of the first word is not zero, the element is
// small: that half holds the number of bytes, the lower half the type, and the data fill the other 4 bytes.
// Compressed elements alone are not padded to a multiple of 8.
Element next_element(ByteReader& reader) {
  const auto first = reader.read<std::uint32_t>();
  if (first >> 16) {
    const std::size_t size = first >> 16;
    const std::string_view four = reader.take(4);
    if (size > 4) reader.refuse("a small data element is larger than its tag");
    return {first & 0xffff, four.substr(0, size)};
  }
  const auto size = reader.read<std::uint32_t>();
  const Element element{first, reader.take(size)};
  if (first != compressed_element) reader.take(std::min<std::size_t>((8 - size % 8) % 8, reader.remaining()));
  return element;
}

// The type of an element is that of its storage, not that of the array: MATLAB writes doubles with whole values in
// the smallest integer type that holds them.
double number(ByteReader& reader, std::uint32_t type) {
  switch (type) {
    case 1:
      return reader.read<std::int8_t>();
    case 2:
      return reader.read<std::uint8_t>();
    case 3:
      return reader.read<std::int16_t>();
    case 4:
      return reader.read<std::uint16_t>();
    case 5:
      return reader.read<std::int32_t>();
    case 6:
      return reader.read<std::uint32_t>();
    case 7:
      return static_cast<double>(reader.read<float>());
    case 9:
      return reader.read<double>();
    case 12:
      return static_cast<double>(reader.read<std::int64_t>());
    case 13:
      return static_cast<double>(reader.read<std::uint64_t>());
    default:
      reader.refuse("numbers of type " + std::to_string(type) + " are not supported");
  }
}

// Walks through the elements behind the header of 128 bytes. The byte order follows from the two letters at byte 126.
// A compressed element contains one array, which is read like any other once it is inflated.
class MatlabReader {
public:
  MatlabReader(std::string_view bytes, const std::string& source)
      : file_(bytes, source, bytes.size() > 127 && bytes[126] == 'M') {
    file_.go_to(128);
  }

  std::vector<ForeignMatrix> read() {
    while (!file_.at_end() && !ended_) take(next_element(file_));
    if (ended_) others_.emplace_back("bytes that are no element");
    if (matrices_.empty())
      file_.refuse("the file has no matrix of real numbers" + passed_over(), "full or sparse matrices are required",
                   "save stiffness and mass as separate variables");
    if (has_others()) matrices_.front().notes.push_back("variables that are no matrices and are not used:" + others());
    return std::move(matrices_);
  }

private:
  void take(const Element& element) {
    if (element.type == compressed_element) {
      const std::string content = uncompressed(element.data, file_.file(), most_unpacked(file_.size()));
      ByteReader inside(content, file_.file(), file_.big_endian());
      const Element array = next_element(inside);
      take_plain(array);
    } else {
      take_plain(element);
    }
  }

  void take_plain(const Element& element) {
    if (element.type == array_element)
      read_array(element.data);
    else if (element.type == 0)  // no type of MATLAB's: what follows is no element
      ended_ = true;
    else
      other_types_.insert(element.type);
  }

  void read_array(std::string_view data) {
    ByteReader reader(data, file_.file(), file_.big_endian());
    ByteReader flag_data = inside(next_element(reader));
    const auto flags = flag_data.read<std::uint32_t>();
    const int kind = static_cast<int>(flags & 0xff);
    const auto lengths = whole_numbers(next_element(reader));
    const std::string name(next_element(reader).data);
    if (kind < sparse_array || kind > last_number_array || lengths.size() != 2) {
      others_.push_back(name.empty() ? "without a name" : name);
      return;
    }
    if (flags & complex_flag)
      file_.refuse("matrix '" + name + "' is complex", "only real matrices are supported",
                   "save stiffness and damping as real matrices");
    if (lengths[0] == 0 || lengths[1] == 0) {
      others_.push_back(name);
      return;
    }
    MatrixEntries entries(file_.file(), name, lengths[0], lengths[1], file_.size() + data.size());
    if (kind == sparse_array)
      read_sparse(reader, entries, lengths);
    else
      read_full(reader, entries, lengths);
    matrices_.push_back(entries.finish(Storage::full));
  }

  // Full arrays run down the columns; zeros are dropped, since all matrices are kept sparse.
  void read_full(ByteReader& reader, MatrixEntries& entries, const std::vector<std::int64_t>& lengths) {
    const Element values = next_element(reader);
    ByteReader numbers = inside(values);
    for (std::int64_t column = 0; column < lengths[1]; ++column)
      for (std::int64_t row = 0; row < lengths[0]; ++row)
        if (const double value = number(numbers, values.type); value != 0.0) entries.add(row, column, value);
    if (!numbers.at_end()) numbers.refuse("a matrix holds more numbers than its size says");
  }

  // Compressed columns: the entries of column j are those from starts[j] up to starts[j + 1]. MATLAB may reserve more
  // room than it fills, so the row list can be longer than the last start.
  void read_sparse(ByteReader& reader, MatrixEntries& entries, const std::vector<std::int64_t>& lengths) {
    const auto rows = whole_numbers(next_element(reader)), starts = whole_numbers(next_element(reader));
    const Element values = next_element(reader);
    ByteReader numbers = inside(values);
    if (static_cast<std::int64_t>(starts.size()) != lengths[1] + 1 || starts.front() != 0)
      file_.refuse("a sparse matrix of " + std::to_string(lengths[1]) + " columns has " +
                   std::to_string(starts.size()) + " column starts");
    for (std::int64_t column = 0; column < lengths[1]; ++column) {
      const std::int64_t begin = starts[static_cast<std::size_t>(column)],
                         end = starts[static_cast<std::size_t>(column) + 1];
      if (begin > end || end > static_cast<std::int64_t>(rows.size()))
        file_.refuse("the column starts of a sparse matrix do not increase");
      for (std::int64_t i = begin; i < end; ++i)
        entries.add(rows[static_cast<std::size_t>(i)], column, number(numbers, values.type));
    }
  }

  [[nodiscard]] ByteReader inside(const Element& element) const {
    return {element.data, file_.file(), file_.big_endian()};
  }

  [[nodiscard]] std::vector<std::int64_t> whole_numbers(const Element& element) const {
    ByteReader reader = inside(element);
    std::vector<std::int64_t> numbers;
    while (!reader.at_end()) {
      const double value = number(reader, element.type);
      if (!(value >= 0.0 && value < 9e15)) file_.refuse("a size or an index is not a whole number");
      numbers.push_back(static_cast<std::int64_t>(value));
    }
    return numbers;
  }

  [[nodiscard]] bool has_others() const { return !others_.empty() || !other_types_.empty(); }
  [[nodiscard]] std::string passed_over() const { return has_others() ? ", only" + others() : ""; }

  [[nodiscard]] std::string others() const {
    std::string text;
    for (const auto& name : others_) text += " '" + name + "'";
    for (const auto type : other_types_) text += " 'element of type " + std::to_string(type) + "'";
    return text;
  }

  ByteReader file_;
  std::vector<ForeignMatrix> matrices_;
  std::vector<std::string> others_;
  bool ended_ = false;
  std::set<std::uint32_t> other_types_;  ///< of elements that are no arrays: a file may hold any number of them
};

}  // namespace

std::vector<ForeignMatrix> parse_matlab(std::string_view bytes, const std::string& source) {
  return MatlabReader(bytes, source).read();
}

}  // namespace kalfem
