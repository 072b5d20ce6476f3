// SPDX-License-Identifier: Apache-2.0
// Inside of the reader of TDMS files only.

#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace kalfem::tdms {

/// Types of values by their numbers in the file.
enum class Type : std::uint32_t {
  none = 0,
  i8 = 1,
  i16 = 2,
  i32 = 3,
  i64 = 4,
  u8 = 5,
  u16 = 6,
  u32 = 7,
  u64 = 8,
  f32 = 9,
  f64 = 10,
  f32_with_unit = 0x19,
  f64_with_unit = 0x1a,
  text = 0x20,
  boolean = 0x21,
  time = 0x44,
  complex_f32 = 0x08000c,
  complex_f64 = 0x10000d,
};

/// Bytes of a value; 0 where it has no fixed size or the type is not known.
std::size_t size_of(Type type);

/// Seconds since 1904 and a fraction in 2^-64 s.
struct Time {
  std::int64_t seconds = 0;
  std::uint64_t fraction = 0;
};

/// [s], exact to a double's digits also between stamps that are close to each other.
double difference(const Time& a, const Time& b);

using Property = std::variant<double, std::string, Time>;
using Properties = std::map<std::string, Property, std::less<>>;

/// Where a DAQmx channel's numbers stand in the rows of a buffer.
struct Scaler {
  Type type = Type::none;
  std::uint32_t buffer = 0;
  std::uint32_t offset = 0;  ///< in the row [bytes]
  int bit = -1;              ///< of a digital line; -1: the whole number
  std::uint32_t id = 0;
};

/// How an object's raw data lie in a chunk.
struct RawIndex {
  bool known = false;  ///< an earlier segment gave it
  Type type = Type::none;
  std::uint64_t count = 0;  ///< values a chunk
  std::uint64_t bytes = 0;  ///< a chunk; for texts as stated
  bool daqmx = false;
  std::vector<Scaler> scalers = {};
  std::vector<std::uint32_t> widths = {};  ///< of a row of each buffer [bytes]
};

/// Numbers of a channel as they are read: of one kind, or of each scaler of a DAQmx channel.
struct Numbers {
  std::uint32_t scaler = 0;
  std::vector<double> values = {};
};

/// The file itself (path "/"), a group or a channel.
struct Object {
  std::string path;
  Properties properties = {};
  RawIndex index = {};
  std::vector<Numbers> numbers = {};   ///< one entry, or one a scaler
  std::vector<double> imaginary = {};  ///< beside the first entry, where values are complex
  Type type = Type::none;              ///< of the values that were read
  std::uint64_t texts = 0;             ///< values that are texts
  bool has_first_time = false;
  Time first_time = {};  ///< time stamps are kept relative to it
};

/// What all segments say, objects in the order of their first mention.
struct Content {
  std::vector<Object> objects = {};
  std::vector<std::string> skipped = {};
};

/// Goes through the segments. Throws InvalidInput where the first one is none.
Content read_segments(std::string_view bytes, const std::string& source);

/// The numbers of an object as its scales (NI_Scale properties of it, its group or the file) make them. Empty, with the
/// reason in `problem`, where a scale is not supported.
std::vector<double> scaled(const Object& object, const std::vector<const Properties*>& levels, std::string& problem);

}  // namespace kalfem::tdms
