// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/tdms/tdms_values.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "kalfem/formats/matrices/entries.hpp"

namespace kalfem::tdms {

std::size_t size_of(Type type) {
  switch (type) {
    case Type::i8:
    case Type::u8:
    case Type::boolean:
      return 1;
    case Type::i16:
    case Type::u16:
      return 2;
    case Type::i32:
    case Type::u32:
    case Type::f32:
    case Type::f32_with_unit:
      return 4;
    case Type::i64:
    case Type::u64:
    case Type::f64:
    case Type::f64_with_unit:
    case Type::complex_f32:
      return 8;
    case Type::time:
    case Type::complex_f64:
      return 16;
    default:
      return 0;
  }
}

// Differences of the integers first: a double holds seconds since 1904 to 0.5 us only.
double difference(const Time& a, const Time& b) {
  const auto seconds = static_cast<double>(a.seconds - b.seconds);
  const double fraction = a.fraction >= b.fraction ? static_cast<double>(a.fraction - b.fraction)
                                                   : -static_cast<double>(b.fraction - a.fraction);
  return seconds + std::ldexp(fraction, -64);
}

Time time_at(const char* bytes, bool big_endian) {
  const int seconds = big_endian ? 0 : 8, fraction = big_endian ? 8 : 0;
  return {value_at<std::int64_t>(bytes + seconds, big_endian), value_at<std::uint64_t>(bytes + fraction, big_endian)};
}

namespace {

template <class Stored>
double as_number(const char* bytes, bool big_endian) {
  return static_cast<double>(value_at<Stored>(bytes, big_endian));
}

}  // namespace

Reader reader_of(Type type) {
  switch (type) {
    case Type::i8:
      return as_number<std::int8_t>;
    case Type::i16:
      return as_number<std::int16_t>;
    case Type::i32:
      return as_number<std::int32_t>;
    case Type::i64:
      return as_number<std::int64_t>;
    case Type::u8:
    case Type::boolean:
      return as_number<std::uint8_t>;
    case Type::u16:
      return as_number<std::uint16_t>;
    case Type::u32:
      return as_number<std::uint32_t>;
    case Type::u64:
      return as_number<std::uint64_t>;
    case Type::f32:
    case Type::f32_with_unit:
    case Type::complex_f32:
      return as_number<float>;
    case Type::f64:
    case Type::f64_with_unit:
    case Type::complex_f64:
      return as_number<double>;
    default:
      return nullptr;
  }
}

namespace {

template <class Stored, bool swapped>
void append_values(const Place& place, std::size_t step, std::vector<double>& values) {
  constexpr bool little = std::endian::native == std::endian::little;
  for (std::uint64_t chunk = 0; chunk < place.chunks; ++chunk) {
    const char* bytes = place.first + chunk * place.stride;
    for (std::uint64_t i = 0; i < place.count; ++i, bytes += step)
      values.push_back(static_cast<double>(value_at<Stored>(bytes, swapped == little)));
  }
}

template <class Stored>
void append(const Place& place, bool big_endian, std::size_t step, std::vector<double>& values) {
  // Room for all: growing by halves is left to the vector where segments are many and small.
  if (place.chunks * place.count > values.capacity() - values.size())
    values.reserve(std::max<std::size_t>(values.size() + place.chunks * place.count, 2 * values.size()));
  if (big_endian == (std::endian::native == std::endian::big))
    append_values<Stored, false>(place, step, values);
  else
    append_values<Stored, true>(place, step, values);
}

}  // namespace

void append_numbers(Type type, const Place& place, bool big_endian, std::vector<double>& values) {
  const auto step = size_of(type);
  switch (type) {
    case Type::i8:
      return append<std::int8_t>(place, big_endian, step, values);
    case Type::i16:
      return append<std::int16_t>(place, big_endian, step, values);
    case Type::i32:
      return append<std::int32_t>(place, big_endian, step, values);
    case Type::i64:
      return append<std::int64_t>(place, big_endian, step, values);
    case Type::u8:
    case Type::boolean:
      return append<std::uint8_t>(place, big_endian, step, values);
    case Type::u16:
      return append<std::uint16_t>(place, big_endian, step, values);
    case Type::u32:
      return append<std::uint32_t>(place, big_endian, step, values);
    case Type::u64:
      return append<std::uint64_t>(place, big_endian, step, values);
    case Type::f32:
    case Type::f32_with_unit:
    case Type::complex_f32:
      return append<float>(place, big_endian, step, values);
    case Type::f64:
    case Type::f64_with_unit:
    case Type::complex_f64:
      return append<double>(place, big_endian, step, values);
    default:
      return;
  }
}

}  // namespace kalfem::tdms
