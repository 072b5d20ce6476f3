// SPDX-License-Identifier: Apache-2.0
// Inside of the reader of TDMS files only.

#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "kalfem/formats/matrices/entries.hpp"
#include "kalfem/formats/tdms/tdms_segments.hpp"

namespace kalfem::tdms {

/// Thrown where the file ends before a part that is begun, or where a part cannot be what it says.
struct Damage {
  std::string what;
};

/// Takes values off the front of a part of the file.
class Cursor {
public:
  Cursor(std::string_view bytes, bool big_endian) : bytes_(bytes), big_endian_(big_endian) {}

  template <class T>
  T read() {
    return value_at<T>(take(sizeof(T)).data(), big_endian_);
  }
  std::string_view take(std::size_t count) {
    if (count > bytes_.size()) throw Damage{"its description is cut off"};
    const auto taken = bytes_.substr(0, count);
    bytes_.remove_prefix(count);
    return taken;
  }
  std::string_view text() { return take(read<std::uint32_t>()); }
  /// A number of things of at least so many bytes each.
  std::uint32_t count(std::size_t least) {
    const auto number = read<std::uint32_t>();
    if (number > bytes_.size() / least) throw Damage{"its description counts more parts than it has room for"};
    return number;
  }
  [[nodiscard]] bool big_endian() const { return big_endian_; }

private:
  std::string_view bytes_;
  bool big_endian_;
};

Property read_property(Cursor& cursor);

/// How the data of a channel lie in a chunk.
RawIndex read_index(Cursor& cursor);
RawIndex read_daqmx_index(Cursor& cursor, bool digital);

/// a b; Damage where no number holds it.
std::uint64_t product(std::uint64_t a, std::uint64_t b);

}  // namespace kalfem::tdms
