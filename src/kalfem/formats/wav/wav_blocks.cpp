// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/wav/wav_blocks.hpp"

#include <algorithm>
#include <optional>

#include "kalfem/base/text.hpp"
#include "kalfem/formats/matrices/entries.hpp"

namespace kalfem {
namespace {

constexpr std::size_t container = 12, block_head = 8;
constexpr std::uint32_t stated_elsewhere = 0xffffffffU;
constexpr int extensible = 0xfffe;

class BlockFinder {
public:
  explicit BlockFinder(std::string_view bytes) : bytes_(bytes) {
    found_.big_endian = bytes.starts_with("RIFX");
    large_ = bytes.starts_with("RF64") || bytes.starts_with("BW64");
  }

  WavBlocks find() {
    for (std::size_t at = container; at + block_head <= bytes_.size();) {
      const auto name = bytes_.substr(at, 4);
      const std::uint32_t stated = whole<std::uint32_t>(at + 4);
      const std::size_t begin = at + block_head, left = bytes_.size() - begin;
      const std::size_t size = name == "data" ? samples_size(stated, begin, left) : std::min<std::size_t>(stated, left);
      take(name, bytes_.substr(begin, size));
      at = next_block(begin + size);
    }
    return std::move(found_);
  }

private:
  template <class T>
  [[nodiscard]] T whole(std::size_t at) const {
    return value_at<T>(bytes_.data() + at, found_.big_endian);
  }

  /// Blocks begin at even bytes; some programs leave the filling byte out.
  [[nodiscard]] std::size_t next_block(std::size_t end) const {
    if (end % 2 == 0) return end;
    return is_block(end) && !is_block(end + 1) ? end : end + 1;
  }

  /// Whether a name and a size that the file has room for stand there.
  [[nodiscard]] bool is_block(std::size_t at) const {
    if (at + block_head > bytes_.size()) return at == bytes_.size();
    const auto name = bytes_.substr(at, 4);
    const bool printable = std::ranges::all_of(name, [](char c) { return c >= ' ' && c <= '~'; });
    return printable && whole<std::uint32_t>(at + 4) <= bytes_.size() - at - block_head;
  }

  /// Bytes of the samples that begin here; `left`: bytes of the file from there on.
  std::size_t samples_size(std::uint32_t stated, std::size_t begin, std::size_t left) {
    std::uint64_t size = large_ && stated == stated_elsewhere && large_size_ ? *large_size_ : stated;
    if (size == 0 && left > 0 && !is_block(begin)) {
      found_.notes.push_back("the header states no samples, as of a recording that was never finished");
      return left;
    }
    if (size <= left) return static_cast<std::size_t>(size);
    found_.notes.push_back("the file is shorter than it states");
    return left;
  }

  void take(std::string_view name, std::string_view block) {
    if (name == "ds64" && block.size() >= 16) {
      large_size_ = value_at<std::uint64_t>(block.data() + 8, false);
    } else if (name == "fmt " && block.size() >= 16 && !found_.has_format) {
      read_format(block);
    } else if (name == "data" && !found_.has_samples) {
      found_.has_samples = !block.empty();
      found_.samples = block;
    } else if (name == "data" && !block.empty()) {
      found_.skipped.push_back("a further block of samples of " + std::to_string(block.size()) + " bytes");
    } else if (name == "LIST" && block.starts_with("INFO")) {
      read_title(block);
    }
  }

  void read_format(std::string_view block) {
    const auto half = [&](std::size_t at) { return value_at<std::uint16_t>(block.data() + at, found_.big_endian); };
    found_.has_format = true;
    found_.format = {.kind = half(0),
                     .channels = half(2),
                     .rate = static_cast<double>(value_at<std::uint32_t>(block.data() + 4, found_.big_endian)),
                     .frame = half(12),
                     .bits = half(14)};
    if (found_.format.kind == extensible && block.size() >= 26) found_.format.kind = half(24);
  }

  void read_title(std::string_view block) {
    for (std::size_t at = 4; at + block_head <= block.size();) {
      const std::size_t size = value_at<std::uint32_t>(block.data() + at + 4, found_.big_endian);
      const auto text = block.substr(at + block_head, size);
      if (block.substr(at, 4) == "INAM") found_.title = to_utf8(text.substr(0, text.find('\0')));
      at += block_head + size + size % 2;
    }
  }

  std::string_view bytes_;
  bool large_ = false;
  std::optional<std::uint64_t> large_size_;
  WavBlocks found_;
};

}  // namespace

WavBlocks find_wav_blocks(std::string_view bytes) {
  return bytes.size() < container ? WavBlocks{} : BlockFinder(bytes).find();
}

}  // namespace kalfem
