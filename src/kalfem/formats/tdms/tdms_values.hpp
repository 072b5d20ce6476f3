// SPDX-License-Identifier: Apache-2.0
// Inside of the reader of TDMS files only.

#pragma once

#include "kalfem/formats/tdms/tdms_segments.hpp"

namespace kalfem::tdms {

Time time_at(const char* bytes, bool big_endian);

/// Reads one value.
using Reader = double (*)(const char* bytes, bool big_endian);
/// Null for types that are no numbers. Of a complex one, its real part.
Reader reader_of(Type type);

/// Where values lie: `count` of each chunk; chunks lie `stride` bytes apart.
struct Place {
  const char* first = nullptr;
  std::size_t stride = 0;
  std::uint64_t chunks = 0;
  std::uint64_t count = 1;
};

/// Appends these values, where they are numbers; of complex ones the real part.
void append_numbers(Type type, const Place& place, bool big_endian, std::vector<double>& values);

}  // namespace kalfem::tdms
