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

  /// Appends what one member holds; returns the bytes that it took.
  std::size_t append_member(std::string_view bytes, std::string& content, std::size_t most) {
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
      content.append(buffer.data(), buffer.size() - stream_.avail_out);
      if (content.size() > most)
        refuse(source_, "the compressed file holds more than " + std::to_string(most) + " bytes");
    }
    return given - stream_.avail_in;
  }

private:
  const std::string& source_;
  z_stream stream_{};
};

}  // namespace

bool is_gzip(std::string_view bytes) { return bytes.starts_with("\x1f\x8b"); }

std::string uncompressed(std::string_view bytes, const std::string& source, std::size_t most) {
  Inflater inflater(source);
  std::string content;
  do {
    bytes.remove_prefix(inflater.append_member(bytes, content, most));
  } while (is_gzip(bytes));
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
