// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/tdms/tdms_description.hpp"

#include <iterator>

#include "kalfem/formats/tdms/tdms_values.hpp"

namespace kalfem::tdms {

Property read_property(Cursor& cursor) {
  const auto type = Type{cursor.read<std::uint32_t>()};
  if (type == Type::text) return std::string(cursor.text());
  if (type == Type::time) return time_at(cursor.take(16).data(), cursor.big_endian());
  const auto reader = reader_of(type);
  if (type == Type::none) {
    cursor.take(1);
    return 0.0;
  }
  if (reader == nullptr)
    throw Damage{"a property has the unknown type " + std::to_string(static_cast<std::uint32_t>(type))};
  return reader(cursor.take(size_of(type)).data(), cursor.big_endian());
}

namespace {

// DAQmx has numbers of types of its own.
Type daqmx_type(std::uint32_t code) {
  constexpr Type types[] = {Type::u8, Type::i8, Type::u16, Type::i16, Type::u32, Type::i32};
  if (code >= std::size(types)) throw Damage{"a DAQmx scaler has the unknown type " + std::to_string(code)};
  return types[code];
}

Scaler read_scaler(Cursor& cursor, bool digital) {
  Scaler scaler;
  scaler.type = daqmx_type(cursor.read<std::uint32_t>());
  scaler.buffer = cursor.read<std::uint32_t>();
  const auto place = cursor.read<std::uint32_t>();
  scaler.offset = digital ? place / 8 : place;
  scaler.bit = digital ? static_cast<int>(place % 8) : -1;
  cursor.take(digital ? 1 : 4);  // the format of the samples
  scaler.id = cursor.read<std::uint32_t>();
  return scaler;
}

}  // namespace

std::uint64_t product(std::uint64_t a, std::uint64_t b) {
  std::uint64_t result = 0;
  if (__builtin_mul_overflow(a, b, &result)) throw Damage{"a channel has more values than any file"};
  return result;
}

RawIndex read_daqmx_index(Cursor& cursor, bool digital) {
  RawIndex index{.known = true, .daqmx = true};
  cursor.take(8);  // type and dimension
  index.count = cursor.read<std::uint64_t>();
  for (auto left = cursor.count(17); left > 0; --left) index.scalers.push_back(read_scaler(cursor, digital));
  for (auto left = cursor.count(4); left > 0; --left) index.widths.push_back(cursor.read<std::uint32_t>());
  for (const auto& scaler : index.scalers)
    if (scaler.buffer >= index.widths.size() || scaler.offset + size_of(scaler.type) > index.widths[scaler.buffer])
      throw Damage{"a DAQmx scaler lies outside of its buffer"};
  return index;
}

RawIndex read_index(Cursor& cursor) {
  RawIndex index{.known = true};
  index.type = Type{cursor.read<std::uint32_t>()};
  cursor.take(4);  // dimension
  index.count = cursor.read<std::uint64_t>();
  const auto size = size_of(index.type);
  if (index.type == Type::text)
    index.bytes = cursor.read<std::uint64_t>();
  else if (size > 0)
    index.bytes = product(index.count, size);
  else
    throw Damage{"a channel has values of type " + std::to_string(static_cast<std::uint32_t>(index.type)) +
                 ", which is not supported"};
  return index;
}

}  // namespace kalfem::tdms
