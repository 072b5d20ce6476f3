// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstring>

#include "formats/matrices_refusal.hpp"

// Binary files of matrices as other programs write them, byte by byte.

namespace kalfem {

/// Values one after the other in an order of bytes.
class Bytes {
public:
  explicit Bytes(bool big_endian = false) : swap_(big_endian != (std::endian::native == std::endian::big)) {}
  template <typename T>
  Bytes& add(T value) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    if (swap_) std::reverse(raw, raw + sizeof(T));
    text.append(raw, sizeof(T));
    return *this;
  }
  Bytes& add(const char* letters, std::size_t width) {
    const std::size_t length = std::strlen(letters);
    text.append(letters, length).append(width - length, ' ');
    return *this;
  }
  Bytes& add(const std::string& bytes) {
    text += bytes;
    return *this;
  }
  /// Fortran's unformatted record.
  Bytes& record(const Bytes& content) {
    const auto length = static_cast<std::int32_t>(content.text.size());
    return add(length).add(content.text).add(length);
  }
  std::string text;

private:
  bool swap_;
};

/// A Nastran file in one of its kinds: order of bytes, integers of 4 or 8 bytes, single or double precision.
struct Kind {
  bool big_endian, long_words, single;

  [[nodiscard]] Bytes bytes() const { return Bytes(big_endian); }
  [[nodiscard]] Bytes whole(std::initializer_list<std::int64_t> numbers) const {
    Bytes result = bytes();
    for (const auto number : numbers) long_words ? result.add(number) : result.add(static_cast<std::int32_t>(number));
    return result;
  }
  void number(Bytes& to, double value) const {
    single && !long_words ? to.add(static_cast<float>(value)) : to.add(value);
  }
  [[nodiscard]] std::int64_t words() const { return single || long_words ? 1 : 2; }
  [[nodiscard]] std::int64_t type() const { return single ? 1 : 2; }
};

inline const std::vector<Kind> kinds = [] {
  std::vector<Kind> all;
  for (const bool big : {false, true})
    for (const bool wide : {false, true})
      for (const bool single : {false, true}) all.push_back({big, wide, single});
  return all;
}();

enum class Columns { dense, short_strings, long_strings };

/// With more numbers in each column than its header states, if that is asked for.
inline std::string op4(const Kind& kind, Columns columns, std::int64_t type = 0, bool with_more = false) {
  Bytes file = kind.bytes();
  const bool bigmat = columns == Columns::long_strings;
  file.record(kind.whole({3, bigmat ? -3 : 3, 6, type > 0 ? type : kind.type()}).add("KAA", kind.long_words ? 16 : 8));
  for (int column = 0; column < 3; ++column) {
    const int first = column == 2 ? 1 : 0, count = column == 1 ? 3 : 2;
    const std::int64_t words = count * kind.words();
    Bytes record = columns == Columns::dense ? kind.whole({column + 1, first + 1, words})
                                             : kind.whole({column + 1, 0, words + (bigmat ? 2 : 1)});
    if (columns == Columns::short_strings) record.add(kind.whole({65536 * (words + 1) + first + 1}).text);
    if (bigmat) record.add(kind.whole({words + 1, first + 1}).text);
    for (int row = first; row < first + count; ++row) kind.number(record, common_matrix(row, column));
    if (with_more) kind.number(record, 7.0);
    file.record(record);
  }
  Bytes last = kind.whole({4, 1, 1});
  kind.number(last, 1.0);
  return file.record(last).text;
}

/// A table, unless it is left out, and a matrix.
inline std::string op2(const Kind& kind, bool with_label, bool with_table = true) {
  Bytes file = kind.bytes();
  const std::size_t name = kind.long_words ? 16 : 8;
  const auto key = [&](std::int64_t value) { file.record(kind.whole({value})); };
  const auto keys = [&](std::initializer_list<std::int64_t> values) {
    for (const auto value : values) key(value);
  };
  const auto begin = [&](const char* title, std::initializer_list<std::int64_t> trailer, std::int64_t matrix) {
    key(2);
    file.record(kind.bytes().add(title, name));
    keys({-1, 7});
    file.record(kind.whole(trailer));
    keys({-2, 1, 0, 2});
    file.record(kind.bytes().add(title, name));
    keys({-3, 1, matrix});
  };
  if (with_label) {
    key(3);
    file.record(kind.whole({1, 2, 26}));
    key(7);
    file.record(kind.bytes().add("NASTRAN FORT TAPE ID CODE - ", 28));
    key(2);
    file.record(kind.bytes().add("LABEL", name));
    keys({-1, 0});
  }
  if (with_table) {
    begin("GEOM1", {101, 0, 0, 0, 0, 0, 0}, 0);
    key(3);
    file.record(kind.whole({4501, 45, 1}));
    keys({-4, 1, 0, 0});
  }
  begin("KAA", {102, 3, 3, 6, kind.type(), 0, 0}, 1);
  for (int column = 0; column < 3; ++column) {
    const int first = column == 2 ? 1 : 0, count = column == 1 ? 3 : 2;
    key(1 + count * kind.words());
    Bytes record = kind.whole({first + 1});
    for (int row = first; row < first + count; ++row) kind.number(record, common_matrix(row, column));
    file.record(record);
    keys({-4 - column, 1, column < 2 ? 1 : 0});
  }
  keys({0, 0});
  return file.text;
}

/// A MATLAB 5 file with one sparse and one full matrix; with more, a text T, an empty E and an element that is no
/// array.
inline std::string matlab(bool big_endian, bool complex = false, bool with_more = false) {
  Bytes file(big_endian);
  file.add("MATLAB 5.0 MAT-file", 124).add(std::uint16_t{0x0100});
  file.add(static_cast<std::uint16_t>('M' << 8 | 'I'));
  const auto array = [&](const Bytes& content) {
    file.add(std::uint32_t{14}).add(static_cast<std::uint32_t>(content.text.size())).add(content.text);
  };
  const auto head = [&](std::uint32_t kind, const char* name) {
    Bytes content(big_endian);
    content.add(std::uint32_t{6}).add(std::uint32_t{8}).add(kind | (complex ? 0x0800u : 0u)).add(std::uint32_t{3});
    content.add(std::uint32_t{5}).add(std::uint32_t{8}).add(std::int32_t{3}).add(std::int32_t{3});
    content.add(std::uint32_t{1 | 1 << 16}).add(name, 4);  // a small element
    return content;
  };
  Bytes sparse = head(5, "K");
  sparse.add(std::uint32_t{5}).add(std::uint32_t{28});
  for (const std::int32_t row : {0, 1, 0, 1, 2, 1, 2, 0}) sparse.add(row);  // with four bytes of padding
  sparse.add(std::uint32_t{5}).add(std::uint32_t{16});
  for (const std::int32_t start : {0, 2, 5, 7}) sparse.add(start);
  sparse.add(std::uint32_t{9}).add(std::uint32_t{56});
  for (const double value : {4.5, -1.0, -1.0, 3.0, -0.25, -0.25, 2.0}) sparse.add(value);
  array(sparse);
  Bytes full = head(6, "F");
  full.add(std::uint32_t{9}).add(std::uint32_t{72});
  for (int i = 0; i < 9; ++i) full.add(common_matrix(i % 3, i / 3));
  array(full);
  if (with_more) {
    Bytes text = head(4, "T");
    text.add(std::uint32_t{4}).add(std::uint32_t{18}).add(std::string(24, '\0'));
    array(text);
    Bytes empty(big_endian);
    empty.add(std::uint32_t{6}).add(std::uint32_t{8}).add(std::uint32_t{6}).add(std::uint32_t{0});
    empty.add(std::uint32_t{5}).add(std::uint32_t{8}).add(std::int32_t{0}).add(std::int32_t{3});
    empty.add(std::uint32_t{1 | 1 << 16}).add("E", 4).add(std::uint32_t{9}).add(std::uint32_t{0});
    array(empty);
    file.add(std::uint32_t{9}).add(std::uint32_t{8}).add(1.0);
  }
  return file.text;
}

/// A superelement in a netCDF classic file of the version 1, 2 or 5; with more, a variable of characters, too.
inline std::string netcdf(int version, bool with_more = false) {
  Bytes file(true);
  const auto count = [&](std::int64_t value) {
    version == 5 ? file.add(value) : file.add(static_cast<std::int32_t>(value));
  };
  const auto name = [&](const char* text) {
    count(static_cast<std::int64_t>(std::strlen(text)));
    file.add(text, std::strlen(text)).add(std::string((4 - std::strlen(text) % 4) % 4, '\0'));
  };
  file.add("CDF", 3).add(static_cast<char>(version));
  count(0);
  file.add(std::int32_t{10});
  count(2);
  name("n");
  count(3);
  name("two");
  count(2);
  file.add(std::int32_t{12});
  count(1);
  name("title");
  file.add(std::int32_t{2});
  count(5);
  file.add("block", 5).add(std::string(3, '\0'));
  file.add(std::int32_t{11});
  count(with_more ? 3 : 2);
  const std::size_t names = 2 * (version == 5 ? 8 : 4);
  const std::size_t entry = names + 8 + 2 * (version == 5 ? 8 : 4) + 4 + (version == 5 ? 8 : 4) + 4 +
                            (version == 5 ? 8 : 4) + (version == 1 ? 4 : 8);
  const std::size_t begin = file.text.size() + 4 * entry + 64;
  const auto variable = [&](const char* title, int second, std::int32_t type, std::size_t at) {
    name(title);
    count(2);
    count(0);
    count(second);
    file.add(std::int32_t{0});
    count(0);
    file.add(type);
    count(0);
    version == 1 ? file.add(static_cast<std::int32_t>(at)) : file.add(static_cast<std::int64_t>(at));
  };
  variable("Kr", 0, 6, begin);
  variable("cbmap", 1, 4, begin + 72);
  if (with_more) {
    variable("names", 1, 2, begin);  // characters
  }
  file.text.resize(begin, '\0');
  for (int i = 0; i < 9; ++i) file.add(common_matrix(i / 3, i % 3));
  for (const std::int32_t number : {0, 0, 7, 1, 7, 6}) file.add(number);
  return file.text;
}

}  // namespace kalfem
