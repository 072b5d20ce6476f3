// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <string_view>

namespace kalfem {

/// Exponents of metre, kilogram, second, kelvin, ampere and radian in twelfths, so that m/s^2/sqrt(Hz) is exact.
/// The radian is kept only to tell rad/s from Hz; elsewhere an angle is a pure number (see compatible()).
struct Dimension {
  std::array<int, 6> twelfths{};
  bool operator==(const Dimension&) const = default;
};

/// A unit: one of it is `factor` in SI.
struct Unit {
  double factor = 1.0;
  Dimension dimension;
};

/// A number as a user gave it, converted to SI. `bare` says that no unit was written: then it is SI already. `per_cent`
/// tells "1 %" from "0.01 m/m", which have the same dimension.
struct Quantity {
  double value = 0.0;
  Dimension dimension;
  bool bare = true;
  bool per_cent = false;
};
/// Equal value and meaning: a bare number equals only a bare number.
bool operator==(const Quantity& a, const Quantity& b);

/// Reads a product of units: "kN/m", "N s/m", "kg·m²", "m/s^2/sqrt(Hz)", "1/s", "N/(m s)"; "" and "-" are
/// dimensionless. Powers are ^2, ^-1, ^0.5, ^(1/3), ² or a digit that follows (s2). SI prefixes stand before g, m, s,
/// N, Pa, J, W, Hz, V, A, K and rad. `g` is the gram; standard gravity is `g0` or `gn`. A space or * after a slash
/// ("N/m s") is refused as ambiguous. Throws InvalidInput that names the part that is not understood.
Unit parse_unit(std::string_view text);

/// The unit of numbers that must have the dimension of `expected_unit`. Where grams do not fit and accelerations do, g
/// (also G, mg, ug) is standard gravity: "g" of an acceleration, "g/N" of an accelerance. Throws InvalidInput where the
/// dimension is another.
Unit parse_unit_as(std::string_view text, std::string_view expected_unit);

/// Reads "15 %", "20 kN/m", "-3e-3"; a number without a unit is SI. The result is finite. Throws InvalidInput.
Quantity parse_quantity(std::string_view text);

/// Whether a value of one dimension may stand where the other is required: equal up to angles, except that an angular
/// velocity (rad/s) is never taken for a frequency (Hz), which would be wrong by 2 pi.
bool compatible(const Dimension& a, const Dimension& b);

/// The SI value of a text where `expected_unit` is required. Throws InvalidInput: "3 mm given where kg is required".
double to_si(std::string_view text, std::string_view expected_unit);

/// As above for a quantity that was read before; it is described in SI.
double to_si(const Quantity& quantity, std::string_view expected_unit);

/// The SI unit of the dimension, which parse_unit() reads back with a factor of one: "N/m", "kg m^2", "-".
std::string si_unit(const Dimension& dimension);

/// Shortest decimal text that reads back as the same double.
std::string shortest(double value);

}  // namespace kalfem
