// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/text_file.hpp"

#include <algorithm>
#include <vector>

#include <zlib.h>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

constexpr int either_header = 15 + 32;               ///< largest window; zlib looks for a gzip or zlib header itself
constexpr std::size_t piece = std::size_t{1} << 20;  ///< bytes handed over at a time

[[noreturn]] void refuse(const std::string& source, std::string what) {
  throw InvalidInput(Issue{{source, 0}, std::move(what), "the whole content is needed", "compress the file again"});
}

class Inflater {
public:
  explicit Inflater(const std::string& source) : source_(source) {
    if (inflateInit2(&stream_, either_header) != Z_OK) refuse(source_, "not enough memory to decompress the file");
  }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;
  ~Inflater() { inflateEnd(&stream_); }

  /// Hands over what one member holds, piece by piece, until `take` wants no more; returns the bytes that it took.
  template <class Take>
  std::size_t read_member(std::string_view bytes, const Take& take) {
    inflateReset(&stream_);
    std::size_t given = 0;
    std::vector<char> buffer(piece);
    int state = Z_OK;
    stream_.avail_in = 0;
    while (state != Z_STREAM_END) {
      if (stream_.avail_in == 0) {
        const std::size_t count = std::min(piece, bytes.size() - given);
        if (count == 0) refuse(source_, "the compressed file is truncated");
        stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data() + given));
        stream_.avail_in = static_cast<uInt>(count);
        given += count;
      }
      stream_.next_out = reinterpret_cast<Bytef*>(buffer.data());
      stream_.avail_out = static_cast<uInt>(buffer.size());
      state = inflate(&stream_, Z_NO_FLUSH);
      if (state != Z_OK && state != Z_STREAM_END && state != Z_BUF_ERROR)
        refuse(source_,
               std::string("the compressed file is damaged: ") + (stream_.msg ? stream_.msg : "no reason given"));
      if (!take(std::string_view(buffer.data(), buffer.size() - stream_.avail_out))) break;
    }
    return given - stream_.avail_in;
  }

private:
  const std::string& source_;
  z_stream stream_{};
};

/// All members; `take` as above.
template <class Take>
void read_members(std::string_view bytes, const std::string& source, const Take& take) {
  Inflater inflater(source);
  bool more = true;
  do {
    bytes.remove_prefix(inflater.read_member(bytes, [&](std::string_view part) { return more = take(part); }));
  } while (more && is_gzip(bytes));
}

}  // namespace

bool is_gzip(std::string_view bytes) { return bytes.starts_with("\x1f\x8b"); }

std::size_t uncompressed_size(std::string_view bytes, const std::string& source, std::size_t most) {
  std::size_t size = 0;
  read_members(bytes, source, [&](std::string_view part) { return (size += part.size()) <= most; });
  return size;
}

std::string uncompressed_head(std::string_view bytes, const std::string& source, std::size_t most) {
  std::string content;
  read_members(bytes, source, [&](std::string_view part) {
    content.append(part.substr(0, most - content.size()));
    return content.size() < most;
  });
  return content;
}

// The size is counted first, so that the content is allocated once.
std::string uncompressed(std::string_view bytes, const std::string& source, std::size_t most) {
  const std::size_t size = uncompressed_size(bytes, source, most);
  if (size > most)
    throw InvalidInput(Issue{{source, 0},
                             "the compressed file unpacks to more than " + std::to_string(most >> 20) + " MiB",
                             "it holds far more than its size says",
                             "unpack it yourself (gunzip; MATLAB: save -v6) if that is meant"});
  std::string content;
  content.reserve(size);
  read_members(bytes, source, [&](std::string_view part) { return content.append(part).size() <= most; });
  return content;
}

namespace {

/// An apostrophe opens a quotation at the start of a word only.
std::size_t opening_mark(std::string_view message) {
  for (std::size_t i = 0; i < message.size(); ++i)
    if (message[i] == '\'' && (i == 0 || message[i - 1] == ' ' || message[i - 1] == '(')) return i;
  return std::string_view::npos;
}

bool is_number_like(std::string_view text) {
  return text.size() <= 24 && text.find_first_not_of("0123456789+-.eEdD") == std::string_view::npos;
}

}  // namespace

std::string without_quotations(std::string_view message) {
  const std::size_t open = opening_mark(message);
  const std::size_t close = message.rfind('\'');
  if (open == std::string_view::npos || close <= open || is_number_like(message.substr(open + 1, close - open - 1)))
    return std::string(message);
  return std::string(message.substr(0, open)) + "'...'" + std::string(message.substr(close + 1));
}

}  // namespace kalfem
