// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "kalfem/formats/universal/dataset_readers.hpp"

namespace kalfem {

/// Where a function of dataset 58 was measured: the name of a component and one of its degrees of freedom.
struct FunctionPlace {
  std::string component = {};  ///< empty where it is NONE
  long node = 0;
  int direction = 0;  ///< as MeasuredPlace
};

/// The text records of dataset 58.
struct FunctionHeader {
  int line = 0;                           ///< of the identifier
  std::array<std::string, 5> texts = {};  ///< without NONE
  int function = 0;                       ///< 1 time response, 4 frequency response, ...
  FunctionPlace response = {}, reference = {};
  bool double_precision = false;
  bool complex = false;
  bool even = true;
  std::uint64_t points = 0;
  double first = 0.0, step = 0.0;          ///< of an even abscissa
  std::array<UniversalAxis, 3> axes = {};  ///< abscissa, numerator and denominator of the ordinate

  /// Numbers that a point is made of: abscissa where it is uneven, real part, imaginary part.
  [[nodiscard]] int numbers_per_point() const { return (even ? 0 : 1) + (complex ? 2 : 1); }
};

/// Reads records 1 to 11. Throws InvalidInput with the line of what is damaged.
FunctionHeader read_function_header(UniversalReading& reading);

/// The numbers of the identifier "    58b     1     2          11        4096" (dataset 58b).
struct BinaryForm {
  long byte_order = 1;      ///< 1 little, 2 big endian; 0: not stated, little
  long floating_point = 2;  ///< 1: DEC, 2: IEEE 754, 3: IBM
  long text_lines = 11;     ///< before the bytes
  std::uint64_t bytes = 0;  ///< 0: not stated
};
BinaryForm binary_form(const std::string& identifier);

/// The even step that was meant by a text of few digits: a rate of 2048 Hz is written 4.88281E-04. The reciprocal is
/// taken where a rounder one lies within the rounding of the text.
double meant_step(std::string_view text, double step);

}  // namespace kalfem
