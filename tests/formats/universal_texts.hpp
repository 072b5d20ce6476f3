// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "base/scratch_folder.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/universal/universal.hpp"

namespace kalfem {

/// Text of universal files by the published description of their datasets: columns as Fortran writes them.
namespace universal_text {

template <typename... Values>
std::string formatted(const char* format, Values... values) {
  std::array<char, 512> text{};
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

inline std::string dataset(const std::string& number, const std::string& content) {
  return "    -1\n" + formatted("%6s", number.c_str()) + "\n" + content + "    -1\n";
}

struct Axis {
  int type = 0;
  std::string label = "NONE", unit = "NONE";
  int length = 0, force = 0, temperature = 0;
};

/// Records 1 to 11 of dataset 58.
struct Function {
  int type = 1;
  long response = 12;
  int direction = 3;
  long reference = 0;
  int reference_direction = 0;
  int data = 2;
  long points = 0;
  int even = 1;
  std::string first = "0.00000E+00", step = "1.00000E-02";
  std::string text = "Wing tip";
  std::string component = "NONE";
  Axis abscissa = {17, "Time", "s"};
  Axis ordinate = {12, "NONE", "NONE"};
  Axis denominator = {};

  [[nodiscard]] std::string records() const {
    std::string lines = formatted("%-80s\n", text.c_str());
    for (int i = 0; i < 4; ++i) lines += formatted("%-80s\n", "NONE");
    lines += formatted("%5d%10d%5d%10d %-10s%10ld%4d %-10s%10ld%4d\n", type, 0, 1, 0, component.c_str(), response,
                       direction, "NONE", reference, reference_direction);
    lines += formatted("%10d%10ld%10d%13s%13s%13s\n", data, points, even, first.c_str(), step.c_str(), "0.00000E+00");
    for (const auto& axis : {abscissa, ordinate, denominator, Axis{}})
      lines += formatted("%10d%5d%5d%5d ", axis.type, axis.length, axis.force, axis.temperature) + axis.label +
               std::string(axis.label.size() < 20 ? 20 - axis.label.size() : 0, ' ') + " " + axis.unit + "\n";
    return lines;
  }

  [[nodiscard]] std::string with(const std::string& samples) const { return dataset("58", records() + samples); }

  /// As dataset 58b: the bytes behind the records, `closing` before the end mark, `counted` bytes in the identifier.
  [[nodiscard]] std::string with_bytes(const std::string& bytes, bool big_endian = false,
                                       const std::string& closing = "", long counted = -1) const {
    return "    -1\n" +
           formatted("%6s%1s%6d%6d%12d%12ld%6d%6d%12d%12d\n", "58", "b", big_endian ? 2 : 1, 2, 11,
                     counted < 0 ? static_cast<long>(bytes.size()) : counted, 0, 0, 0, 0) +
           records() + bytes + closing + "    -1\n";
  }
};

/// Numbers as bytes of one order.
template <typename Number>
std::string bytes_of(const std::vector<Number>& numbers, bool big_endian = false) {
  std::string bytes;
  for (const Number number : numbers) {
    std::array<char, sizeof(Number)> raw{};
    std::memcpy(raw.data(), &number, sizeof number);
    if (big_endian != (std::endian::native == std::endian::big)) std::reverse(raw.begin(), raw.end());
    bytes.append(raw.data(), raw.size());
  }
  return bytes;
}

}  // namespace universal_text

/// Reads texts as universal files.
class UniversalFiles : public testing::Test {
protected:
  std::filesystem::path file(const std::string& content, const std::string& name = "test.unv") const {
    std::ofstream(folder_ / name, std::ios::binary) << content;
    return folder_ / name;
  }
  static MeasuredFile read(const std::string& content) { return parse_universal(content, "test.unv"); }
  static std::string refusal(const std::string& content) {
    try {
      read(content);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  }

  ScratchFolder folder_{"universal"};
};

}  // namespace kalfem
