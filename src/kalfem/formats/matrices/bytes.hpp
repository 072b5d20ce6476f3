#pragma once

// Inside of the readers of binary files only.

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "kalfem/formats/matrices/entries.hpp"

namespace kalfem {

/// The value that begins at `bytes`, in the given order of bytes.
template <typename T>
T value_at(const char* bytes, bool big_endian) {
  char ordered[sizeof(T)];
  std::memcpy(ordered, bytes, sizeof(T));
  if (big_endian != (std::endian::native == std::endian::big)) std::reverse(ordered, ordered + sizeof(T));
  T value;
  std::memcpy(&value, ordered, sizeof(T));
  return value;
}

/// Reads a binary file value by value and never beyond its end.
class ByteReader {
public:
  ByteReader(std::string_view bytes, std::string file, bool big_endian)
      : bytes_(bytes), file_(std::move(file)), big_endian_(big_endian) {}

  template <typename T>
  T read() {
    return value_at<T>(take(sizeof(T)).data(), big_endian_);
  }

  std::string_view take(std::size_t count) {
    if (count > remaining()) refuse("the file ends, but " + std::to_string(count) + " more bytes are expected");
    const std::string_view taken = bytes_.substr(position_, count);
    position_ += count;
    return taken;
  }

  void go_to(std::size_t position) {
    if (position > bytes_.size())
      refuse("the file ends before byte " + std::to_string(position) + " that it refers to");
    position_ = position;
  }

  [[nodiscard]] std::size_t position() const { return position_; }
  [[nodiscard]] std::size_t remaining() const { return bytes_.size() - position_; }
  [[nodiscard]] std::size_t size() const { return bytes_.size(); }
  [[nodiscard]] bool at_end() const { return remaining() == 0; }
  [[nodiscard]] bool big_endian() const { return big_endian_; }
  [[nodiscard]] const std::string& file() const { return file_; }

  [[noreturn]] void refuse(std::string what, std::string why = "the file is truncated or damaged",
                           std::string fix = "export the file again") const {
    refuse_matrix(file_, 0, std::move(what) + " (at byte " + std::to_string(position_) + ")", std::move(why),
                  std::move(fix));
  }

private:
  std::string_view bytes_;
  std::string file_;
  bool big_endian_;
  std::size_t position_ = 0;
};

}  // namespace kalfem
