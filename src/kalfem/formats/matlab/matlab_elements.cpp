// SPDX-License-Identifier: Apache-2.0
// The shell of MATLAB files of the versions 5 to 7.2 [MAT5]: what libmatio does not tell. It stops without a word where
// a file was cut off, does not name the classes of objects, and makes room for as many cells as a damaged file counts.

#include <algorithm>
#include <optional>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/mapped_file.hpp"
#include "kalfem/formats/matlab/matlab_values.hpp"
#include "kalfem/formats/matrices/entries.hpp"
#include "kalfem/formats/text_file.hpp"

namespace kalfem {
namespace {

constexpr std::size_t header_length = 128, tag_length = 8;
constexpr std::uint32_t array_element = 14, compressed_element = 15;
constexpr std::uint32_t cell_class = 1, structure_class = 2, object_class = 3, sparse_class = 5, opaque_class = 17;
constexpr std::uint32_t complex_flag = 0x0800;
constexpr int deepest = 32;

/// Elements of an array one after the other, each with its tag; small ones have their data in the tag.
class Parts {
public:
  Parts(std::string_view bytes, bool big_endian) : bytes_(bytes), big_endian_(big_endian) {}

  std::optional<std::string_view> next() {
    if (bytes_.size() < tag_length) return std::nullopt;
    const auto first = value_at<std::uint32_t>(bytes_.data(), big_endian_);
    const bool small = first >> 16 != 0;
    const std::size_t size = small ? first >> 16 : value_at<std::uint32_t>(bytes_.data() + 4, big_endian_);
    const std::size_t start = small ? 4 : tag_length;
    if (size > bytes_.size() - start) return std::nullopt;
    const auto data = bytes_.substr(start, size);
    bytes_.remove_prefix(std::min(bytes_.size(), small ? tag_length : start + (size + 7) / 8 * 8));
    return data;
  }

  /// Bytes that the next element states to have, whether they are there or not; 0 where there is no tag.
  [[nodiscard]] std::size_t stated() const {
    if (bytes_.size() < tag_length) return 0;
    const auto first = value_at<std::uint32_t>(bytes_.data(), big_endian_);
    return first >> 16 != 0 ? first >> 16 : value_at<std::uint32_t>(bytes_.data() + 4, big_endian_);
  }

private:
  std::string_view bytes_;
  bool big_endian_;
};

/// Flags, name, "MCOS", class: of an object only.
void take_object(std::string_view array, bool big_endian, MatlabElements& found) {
  Parts parts(array, big_endian);
  const auto flags = parts.next();
  if (!flags || flags->size() < 4) return;
  if ((value_at<std::uint32_t>(flags->data(), big_endian) & 0xff) != opaque_class) return;
  const auto name = parts.next(), system = parts.next(), kind = parts.next();
  if (name && system && kind) found.objects.emplace_back(std::string(*name), std::string(*kind));
}

/// Number of elements by the lengths; nothing where these are more than `most`.
std::optional<std::size_t> element_count(std::string_view lengths, bool big_endian, std::size_t most) {
  std::size_t count = 1;
  for (std::size_t at = 0; at + 4 <= lengths.size(); at += 4) {
    const auto length = value_at<std::int32_t>(lengths.data() + at, big_endian);
    if (length < 0 || __builtin_mul_overflow(count, static_cast<std::size_t>(length), &count)) return std::nullopt;
  }
  return count <= most ? std::optional(count) : std::nullopt;
}

/// Checks arrays, and counts what they take in memory once they are read.
class ArrayCheck {
public:
  explicit ArrayCheck(bool big_endian) : big_endian_(big_endian) {}

  /// Whether an array can have as many parts as it says. An empty one has none at all. Of an array of numbers its
  /// beginning is enough; `bytes` is its whole length.
  bool is_sound(std::string_view array, std::size_t bytes, int depth) {
    if (array.empty()) return true;
    if (depth > deepest) return false;
    Parts parts(array, big_endian_);
    const auto flags = parts.next();
    if (!flags || flags->size() < 4) return false;
    const auto flag = value_at<std::uint32_t>(flags->data(), big_endian_);
    const auto kind = flag & 0xff;
    unpacked_ += bytes_of_a_part;
    if (kind == opaque_class) return true;
    const auto lengths = parts.next(), name = parts.next();
    if (!lengths || !name) return false;
    const auto count = element_count(*lengths, big_endian_, kind == sparse_class ? ~std::size_t{0} : bytes);
    if (!count) return false;
    if (kind == cell_class) return are_sound(parts, *count, depth);
    if (kind == structure_class || kind == object_class) return is_sound_structure(parts, *count, bytes, kind, depth);
    unpacked_ += kind == sparse_class ? bytes : *count * sizeof(double) * (flag & complex_flag ? 2 : 1);
    if (parts.stated() > bytes) return false;  // libmatio makes room for what the tag states
    if (kind == sparse_class || *count == 0) return true;
    const auto values = parts.next();
    return !values || values->size() >= *count;
  }

  [[nodiscard]] std::uintmax_t unpacked() const { return unpacked_; }

private:
  static constexpr std::size_t bytes_of_a_part = 512;  ///< of a cell or a field, beside its numbers

  /// Whether none of the arrays that follow counts more parts than it has bytes. Some programs state too few bytes, so
  /// that the last arrays cannot be found: libmatio looks for itself.
  bool are_sound(Parts& parts, std::size_t count, int depth) {
    unpacked_ += count * bytes_of_a_part;
    for (; count > 0; --count) {
      const auto inner = parts.next();
      if (!inner) return true;
      if (!is_sound(*inner, inner->size(), depth + 1)) return false;
    }
    return true;
  }

  bool is_sound_structure(Parts& parts, std::size_t count, std::size_t most, std::uint32_t kind, int depth) {
    if (kind == object_class && !parts.next()) return false;  // name of the class
    const auto length = parts.next(), names = parts.next();
    if (!length || length->size() < 4 || !names) return false;
    const auto one = value_at<std::int32_t>(length->data(), big_endian_);
    if (one <= 0) return names->empty() || count == 0;
    const std::size_t fields = count * (names->size() / static_cast<std::size_t>(one));
    return fields <= most && are_sound(parts, fields, depth);
  }

  bool big_endian_;
  std::uintmax_t unpacked_ = 0;
};

/// Class and name of an array, as far as its beginning shows them.
struct ArrayHead {
  std::uint32_t kind = 0;
  std::string name;
  [[nodiscard]] bool has_parts() const { return kind == cell_class || kind == structure_class || kind == object_class; }
};

ArrayHead head_of(std::string_view array, bool big_endian) {
  Parts parts(array, big_endian);
  const auto flags = parts.next();
  if (!flags || flags->size() < 4) return {};
  ArrayHead head{value_at<std::uint32_t>(flags->data(), big_endian) & 0xff, ""};
  const auto lengths = parts.next(), name = parts.next();
  if (lengths && name) head.name = *name;
  return head;
}

/// The array that a top element is or holds compressed: all of it where it has parts, otherwise its beginning at least.
struct TopArray {
  std::string_view bytes;  ///< of the file or of `content`
  std::size_t length = 0;  ///< of the whole array
  bool too_large = false;  ///< it has parts and goes over the budget
  std::string content = {};
};

/// Throws InvalidInput where the compressed array is damaged.
TopArray unpacked_array(std::string_view data, bool big_endian, const UnpackedBudget& budget) {
  constexpr std::size_t beginning = std::size_t{64} << 10, any = std::size_t{1} << 40;
  TopArray array;
  const std::size_t whole = uncompressed_size(data, "", any);
  array.length = whole - std::min(whole, tag_length);
  array.content = uncompressed_head(data, "", beginning);
  if (array.content.size() <= tag_length) return array;
  const auto head = head_of(std::string_view(array.content).substr(tag_length), big_endian);
  array.too_large = head.has_parts() && whole > budget.left(head.name);
  if (head.has_parts() && !array.too_large) array.content = uncompressed(data, "", whole);
  return array;
}

/// False where the array is not sound, or too large.
bool take_array(std::uint32_t type, std::string_view data, bool big_endian, const UnpackedBudget& budget,
                MatlabElements& found) {
  TopArray array{data, data.size()};
  if (type == compressed_element) {
    try {
      array = unpacked_array(data, big_endian, budget);
    } catch (const InvalidInput&) {
      return false;
    }
    array.bytes = std::string_view(array.content).substr(std::min(array.content.size(), tag_length));
  }
  if (array.too_large) found.too_large = array.length;
  ArrayCheck check(big_endian);
  if (array.too_large || array.bytes.empty() || !check.is_sound(array.bytes, array.length, 0)) return false;
  take_object(array.bytes, big_endian, found);
  found.unpacked.push_back(check.unpacked());
  ++found.arrays;
  return true;
}

}  // namespace

MatlabElements scan_matlab_elements(const std::filesystem::path& path, const UnpackedBudget& budget) {
  const MappedFile file(path);
  const auto bytes = file.bytes();
  MatlabElements found;
  if (bytes.size() < header_length) {
    found.cut_off = true;
    return found;
  }
  const bool big_endian = bytes[header_length - 2] == 'M';
  for (std::size_t at = header_length; at < bytes.size();) {
    if (bytes.size() - at < tag_length) {
      found.cut_off = true;
      break;
    }
    const auto type = value_at<std::uint32_t>(bytes.data() + at, big_endian);
    const std::size_t size = value_at<std::uint32_t>(bytes.data() + at + 4, big_endian);
    if (size > bytes.size() - at - tag_length) {
      found.cut_off = true;
      break;
    }
    const bool array = type == array_element || type == compressed_element;
    if (array && !take_array(type, bytes.substr(at + tag_length, size), big_endian, budget, found)) {
      if (found.too_large == 0) found.damaged_at = at;
      break;
    }
    at += tag_length + size;
  }
  return found;
}

// A matrix of version 4 is five whole numbers (kind, rows, columns, imaginary part, length of the name), name and
// numbers.
bool is_matlab_4(const std::filesystem::path& path) {
  constexpr std::size_t widths[] = {8, 4, 4, 2, 2, 1};
  const MappedFile file(path);
  auto bytes = file.bytes();
  if (bytes.empty()) return false;
  while (!bytes.empty()) {
    if (bytes.size() < 20) return false;
    const bool big_endian = value_at<std::uint32_t>(bytes.data(), false) > 4052;
    std::uint64_t header[5];
    for (int i = 0; i < 5; ++i) header[i] = value_at<std::uint32_t>(bytes.data() + 4 * i, big_endian);
    const auto type = header[0] / 10 % 10;
    if (header[0] > 4052 || type >= std::size(widths) || header[3] > 1 || header[4] > bytes.size()) return false;
    std::uint64_t size = 0;
    if (__builtin_mul_overflow(header[1] * header[2], widths[type] * (1 + header[3]), &size)) return false;
    if (size > bytes.size() || 20 + header[4] + size > bytes.size()) return false;
    bytes.remove_prefix(20 + header[4] + size);
  }
  return true;
}

}  // namespace kalfem
