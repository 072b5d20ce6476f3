// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <string>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/units.hpp"

namespace kalfem {

/// The accepted numbers: low <= x <= high, with < at an open end.
struct Bounds {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_open = false, high_open = false;

  static Bounds any() { return {}; }
  static Bounds positive() { return {.low = 0.0, .low_open = true}; }
  static Bounds nonnegative() { return {.low = 0.0}; }
  static Bounds between(double low, double high) { return {.low = low, .high = high}; }

  [[nodiscard]] bool contain(double x) const;
  /// "> 0", "in [0, 1]" ..., "" when every number is accepted.
  [[nodiscard]] std::string to_string() const;
};

/// Returns the value in SI. Throws InvalidInput if it does not parse, or if the unit or the bounds do not fit.
double checked_number(const std::string& text, const std::string& unit, const Bounds& bounds);
/// The same for a quantity whose unit was not known when it was read. Throws InvalidInput with its place.
double checked_number(const Located<Quantity>& given, const std::string& unit, const Bounds& bounds = {});

}  // namespace kalfem
