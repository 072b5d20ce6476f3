// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/tdms/tdms_segments.hpp"

#include <algorithm>
#include <unordered_map>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/matrices/entries.hpp"
#include "kalfem/formats/tdms/tdms_description.hpp"
#include "kalfem/formats/tdms/tdms_values.hpp"

namespace kalfem::tdms {

namespace {

constexpr std::size_t lead_in = 28;
constexpr std::uint64_t unknown_length = ~std::uint64_t{0};
constexpr std::uint32_t has_metadata = 1u << 1, new_list = 1u << 2, has_raw_data = 1u << 3, interleaved_data = 1u << 5,
                        big_endian_data = 1u << 6;
constexpr std::uint32_t no_raw_data = 0xffffffffu, as_before = 0, format_changing = 0x1269, digital_line = 0x1369,
                        digital_line_as_documented = 0x126a;
constexpr std::size_t most_notes = 20;

struct TextHash {
  using is_transparent = void;
  std::size_t operator()(std::string_view text) const { return std::hash<std::string_view>()(text); }
};

/// Reads segment after segment into the objects.
class SegmentReader {
public:
  SegmentReader(std::string_view bytes, std::string source) : bytes_(bytes), source_(std::move(source)) {}

  Content read() {
    std::size_t position = 0;
    while (position < bytes_.size()) {
      const std::size_t next = read_segment(position);
      if (next <= position) break;
      position = next;
    }
    if (left_out_ > 0) content_.skipped.push_back("and " + std::to_string(left_out_) + " more parts of this kind");
    return std::move(content_);
  }

private:
  void note(std::string words) {
    if (content_.skipped.size() < most_notes)
      content_.skipped.push_back(std::move(words));
    else
      ++left_out_;
  }

  [[nodiscard]] static std::string at(std::size_t position) {
    return "the segment at byte " + std::to_string(position);
  }

  /// Where the next one begins; nothing further can be read where that is not behind this one.
  std::size_t read_segment(std::size_t position) {
    const auto rest = bytes_.substr(position);
    if (!rest.starts_with("TDSm")) return refuse_start(position);
    if (rest.size() < lead_in) {
      note(at(position) + " is cut off in its first " + std::to_string(lead_in) + " bytes");
      return position;
    }
    const auto flags = value_at<std::uint32_t>(rest.data() + 4, false);
    const bool big_endian = (flags & big_endian_data) != 0;
    const auto length = value_at<std::uint64_t>(rest.data() + 12, big_endian),
               description = value_at<std::uint64_t>(rest.data() + 20, big_endian);
    const std::uint64_t present = rest.size() - lead_in;
    const bool cut = length == unknown_length || length > present;
    const std::uint64_t size = cut ? present : length;
    if (cut) note_cut(position, length, present);
    if (description > size) {
      note(at(position) + " is damaged: its description ends behind it");
      return cut ? position : position + lead_in + size;
    }
    read_parts(position, flags, rest.substr(lead_in, size), description, cut);
    return cut ? bytes_.size() : position + lead_in + size;
  }

  std::size_t refuse_start(std::size_t position) {
    if (position > 0) {
      note("what follows byte " + std::to_string(position) + " is no segment of a TDMS file");
      return position;
    }
    const bool index = bytes_.starts_with("TDSh");
    throw InvalidInput(Issue{{source_, 0},
                             index ? "the file is the index of a TDMS file" : "the file is no TDMS file",
                             index ? "it holds no samples" : "it does not begin with TDSm",
                             index ? "give the .tdms file beside it" : "export it again"});
  }

  void note_cut(std::size_t position, std::uint64_t length, std::uint64_t present) {
    note(at(position) + " is cut off" +
         (length == unknown_length ? ": it was never finished"
                                   : ": " + std::to_string(length - present) + " of its bytes are missing") +
         "; what is whole of it is read");
  }

  void read_parts(std::size_t position, std::uint32_t flags, std::string_view segment, std::uint64_t description,
                  bool cut) {
    try {
      const bool big_endian = (flags & big_endian_data) != 0;
      if (flags & has_metadata) {
        layout_sound_ = false;
        read_description(Cursor(segment.substr(0, description), big_endian), (flags & new_list) != 0);
        layout_sound_ = true;
      } else if (!layout_sound_) {
        throw Damage{"it repeats a description that is missing"};
      }
      if (flags & has_raw_data) read_raw(segment.substr(description), (flags & interleaved_data) != 0, big_endian, cut);
    } catch (const Damage& damage) {
      note(at(position) + " is not read: " + damage.what);
    }
  }

  std::size_t number_of(std::string_view path) {
    if (const auto found = numbers_.find(path); found != numbers_.end()) return found->second;
    content_.objects.push_back({.path = std::string(path)});
    numbers_.emplace(std::string(path), content_.objects.size() - 1);
    slots_.push_back(not_listed);
    return content_.objects.size() - 1;
  }

  void read_description(Cursor cursor, bool fresh) {
    if (fresh) {
      for (const auto& entry : listed_) slots_[entry.number] = not_listed;
      listed_.clear();
    }
    for (auto left = cursor.count(12); left > 0; --left) {
      const auto number = number_of(cursor.text());
      read_object(cursor, number);
      Object& object = content_.objects[number];
      for (auto properties = cursor.count(9); properties > 0; --properties) {
        std::string name(cursor.text());
        object.properties.insert_or_assign(std::move(name), read_property(cursor));
      }
    }
    active_.clear();
    for (const auto& entry : listed_)
      if (entry.has_data) active_.push_back(entry.number);
  }

  void read_object(Cursor& cursor, std::size_t number) {
    Object& object = content_.objects[number];
    const auto header = cursor.read<std::uint32_t>();
    if (slots_[number] == not_listed) {
      slots_[number] = listed_.size();
      listed_.push_back({number, false});
    }
    auto& has_data = listed_[slots_[number]].has_data;
    has_data = false;
    if (header == no_raw_data) return;
    if (header == format_changing || header == digital_line || header == digital_line_as_documented)
      object.index = read_daqmx_index(cursor, header != format_changing);
    else if (header != as_before)
      object.index = read_index(cursor);
    else if (!object.index.known)
      throw Damage{"'" + object.path + "' repeats a layout that no segment gave"};
    has_data = true;
  }

  void read_raw(std::string_view data, bool interleaved, bool big_endian, bool cut) {
    if (data.empty()) return;
    const auto daqmx = std::ranges::count_if(active_, [&](std::size_t i) { return content_.objects[i].index.daqmx; });
    if (daqmx > 0 && daqmx < std::ssize(active_)) throw Damage{"it mixes DAQmx data with others"};
    if (daqmx > 0)
      read_daqmx(data, big_endian);
    else if (interleaved)
      read_interleaved(data, big_endian);
    else
      read_contiguous(data, big_endian, cut);
  }

  void read_interleaved(std::string_view data, bool big_endian) {
    std::size_t width = 0;
    for (const auto i : active_) {
      const auto size = size_of(content_.objects[i].index.type);
      if (size == 0) throw Damage{"it interleaves texts"};
      width += size;
    }
    if (width == 0) throw Damage{"it has data of no channel"};
    std::size_t offset = 0;
    for (const auto i : active_) {
      take(content_.objects[i], {data.data() + offset, width, data.size() / width, 1}, big_endian);
      offset += size_of(content_.objects[i].index.type);
    }
    note_rest(data.size() % width);
  }

  void note_rest(std::size_t bytes) {
    if (bytes > 0) note(std::to_string(bytes) + " bytes at the end of a segment are not a whole row of samples");
  }

  void read_contiguous(std::string_view data, bool big_endian, bool cut) {
    std::uint64_t chunk = 0;
    for (const auto i : active_)
      if (__builtin_add_overflow(chunk, content_.objects[i].index.bytes, &chunk))
        throw Damage{"its channels have more values than any file"};
    if (chunk == 0) throw Damage{"it has data of no channel"};
    const std::uint64_t chunks = data.size() / chunk, rest = data.size() % chunk;
    std::uint64_t offset = 0;
    for (const auto i : active_) {
      Object& object = content_.objects[i];
      if (chunks > 0) take(object, {data.data() + offset, chunk, chunks, object.index.count}, big_endian);
      offset += object.index.bytes;
    }
    if (rest > 0) read_last_chunk(data.substr(chunks * chunk), chunk, big_endian, cut);
  }

  // A finished segment may end in a chunk of fewer values of every channel. In one that was cut off the first channels
  // are whole, and those behind the cut have none.
  void read_last_chunk(std::string_view data, std::uint64_t chunk, bool big_endian, bool cut) {
    const double share = static_cast<double>(data.size()) / static_cast<double>(chunk);
    std::size_t offset = 0;
    for (const auto i : active_) {
      Object& object = content_.objects[i];
      const auto size = size_of(object.index.type);
      if (size == 0) throw Damage{"its last chunk is cut off and holds texts"};
      const std::uint64_t room = (data.size() - offset) / size;
      const auto planned =
          cut ? object.index.count : static_cast<std::uint64_t>(static_cast<double>(object.index.count) * share + 1e-6);
      const std::uint64_t count = std::min(planned, room);
      take(object, {data.data() + offset, 0, 1, count}, big_endian);
      if (cut && count < object.index.count)
        note(object.path + " misses the last " + std::to_string(object.index.count - count) +
             " samples of its last chunk");
      offset += static_cast<std::size_t>(count) * size;
    }
    if (!cut) note_rest(data.size() - offset);
  }

  void take(Object& object, const Place& place, bool big_endian) {
    if (object.numbers.empty()) object.numbers.resize(1);
    const Type type = object.index.type;
    if (type == Type::text) {
      object.texts += place.chunks * place.count;
      return;
    }
    object.type = type;
    if (type == Type::time) return take_times(object, place, big_endian);
    append_numbers(type, place, big_endian, object.numbers.front().values);
    if (type != Type::complex_f32 && type != Type::complex_f64) return;
    Place imaginary = place;
    imaginary.first += size_of(type) / 2;
    append_numbers(type, imaginary, big_endian, object.imaginary);
  }

  static void take_times(Object& object, const Place& place, bool big_endian) {
    for (std::uint64_t chunk = 0; chunk < place.chunks; ++chunk)
      for (std::uint64_t i = 0; i < place.count; ++i) {
        const Time time = time_at(place.first + chunk * place.stride + i * 16, big_endian);
        if (!object.has_first_time) object.first_time = time;
        object.has_first_time = true;
        object.numbers.front().values.push_back(difference(time, object.first_time));
      }
  }

  // A chunk holds the buffers one behind the other, each with as many rows as its channels have values.
  void read_daqmx(std::string_view data, bool big_endian) {
    const auto& widths = content_.objects[active_.front()].index.widths;
    std::vector<std::uint64_t> rows(widths.size(), 0), starts;
    for (const auto i : active_) {
      const auto& index = content_.objects[i].index;
      if (index.widths != widths) throw Damage{"its DAQmx channels state different buffers"};
      for (const auto& scaler : index.scalers) rows[scaler.buffer] = std::max(rows[scaler.buffer], index.count);
    }
    std::uint64_t chunk = 0;
    for (std::size_t buffer = 0; buffer < widths.size(); ++buffer) {
      starts.push_back(chunk);
      if (__builtin_add_overflow(chunk, product(rows[buffer], widths[buffer]), &chunk))
        throw Damage{"its channels have more values than any file"};
    }
    if (chunk == 0) throw Damage{"it has data of no channel"};
    const std::uint64_t chunks = data.size() / chunk, rest = data.size() % chunk;
    for (const auto i : active_)
      for (const auto& scaler : content_.objects[i].index.scalers)
        take_scaler(content_.objects[i], scaler, data,
                    {starts[scaler.buffer], widths[scaler.buffer], chunk, chunks, rest}, big_endian);
  }

  struct Buffer {
    std::uint64_t start = 0, width = 0, chunk = 0, chunks = 0, rest = 0;  ///< [bytes]; chunks: their number
  };

  static std::vector<double>& values_of(Object& object, std::uint32_t scaler) {
    for (auto& numbers : object.numbers)
      if (numbers.scaler == scaler) return numbers.values;
    return object.numbers.emplace_back(Numbers{scaler, {}}).values;
  }

  static void take_scaler(Object& object, const Scaler& scaler, std::string_view data, const Buffer& buffer,
                          bool big_endian) {
    auto& values = values_of(object, scaler.id);
    object.type = scaler.type;
    const std::size_t before = values.size();
    for (std::uint64_t chunk = 0; chunk <= buffer.chunks; ++chunk) {
      const std::uint64_t first = chunk * buffer.chunk + buffer.start;
      const std::uint64_t whole = chunk < buffer.chunks ? object.index.count : rows_in_rest(buffer, object.index.count);
      append_numbers(
          scaler.type,
          {data.data() + std::min<std::uint64_t>(first + scaler.offset, data.size()), buffer.width, whole, 1},
          big_endian, values);
    }
    if (scaler.bit >= 0)
      for (auto value = values.begin() + static_cast<std::ptrdiff_t>(before); value != values.end(); ++value)
        *value = static_cast<double>((static_cast<std::int64_t>(*value) >> scaler.bit) & 1);
  }

  static std::uint64_t rows_in_rest(const Buffer& buffer, std::uint64_t count) {
    return buffer.rest <= buffer.start ? 0 : std::min(count, (buffer.rest - buffer.start) / buffer.width);
  }

  std::string_view bytes_;
  std::string source_;
  Content content_;
  std::unordered_map<std::string, std::size_t, TextHash, std::equal_to<>> numbers_;
  /// An object of the current list; it keeps its place while it has no data.
  struct Listed {
    std::size_t number = 0;
    bool has_data = false;
  };
  static constexpr std::size_t not_listed = ~std::size_t{0};
  std::vector<Listed> listed_;
  std::vector<std::size_t> slots_;   ///< of each object in the list
  std::vector<std::size_t> active_;  ///< objects with raw data, in the order in which these lie
  bool layout_sound_ = false;
  std::size_t left_out_ = 0;
};

}  // namespace

Content read_segments(std::string_view bytes, const std::string& source) { return SegmentReader(bytes, source).read(); }

}  // namespace kalfem::tdms
