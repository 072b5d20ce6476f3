// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/universal/universal_units.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/text.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/formats/unit_labels.hpp"

namespace kalfem {
namespace {

constexpr double same_factor = 1e-4;  ///< relative; factors of dataset 164 have few digits in some files

/// A specific data type: its quantity, SI unit, and the powers of length and force in it; the same of a rotation.
struct DataType {
  int number;
  std::string_view quantity, unit;
  int length, force;
  std::string_view rotation, rotation_unit;
  int rotation_length, rotation_force;
};

constexpr std::array data_types = {
    DataType{2, "stress", "Pa", -2, 1, "stress", "Pa", -2, 1},
    DataType{3, "strain", "-", 0, 0, "strain", "-", 0, 0},
    DataType{5, "temperature", "K", 0, 0, "temperature", "K", 0, 0},
    DataType{8, "displacement", "m", 1, 0, "rotation", "rad", 0, 0},
    DataType{9, "force", "N", 0, 1, "moment", "N m", 1, 1},
    DataType{11, "velocity", "m/s", 1, 0, "angular velocity", "rad/s", 0, 0},
    DataType{12, "acceleration", "m/s^2", 1, 0, "angular acceleration", "rad/s^2", 0, 0},
    DataType{13, "force", "N", 0, 1, "moment", "N m", 1, 1},
    DataType{15, "pressure", "Pa", -2, 1, "pressure", "Pa", -2, 1},
    DataType{16, "mass", "kg", -1, 1, "mass", "kg", -1, 1},
    DataType{17, "time", "s", 0, 0, "time", "s", 0, 0},
    DataType{18, "frequency", "Hz", 0, 0, "frequency", "Hz", 0, 0},
    DataType{19, "rotational speed", "rpm", 0, 0, "rotational speed", "rpm", 0, 0},
};

bool is_rotation(int direction) { return std::abs(direction) >= 4; }

const DataType* data_type(int number) {
  const auto found = std::ranges::find(data_types, number, &DataType::number);
  return found == data_types.end() ? nullptr : &*found;
}

std::optional<Unit> parsed(const std::string& text, const std::string& expected = {}) {
  try {
    return expected.empty() ? parse_unit(text) : parse_unit_as(text, expected);
  } catch (const InvalidInput&) {
    return std::nullopt;
  }
}

/// SI unit of the axis and the factor into it, by its data type or by its exponents; nothing where it has neither.
std::optional<AxisUnit> si_of(const UniversalAxis& axis, int direction, const UniversalUnits& units) {
  if (axis.type == 1 && (axis.length != 0 || axis.force != 0 || axis.temperature != 0)) {
    const auto power = [](const char* symbol, int exponent) {
      return exponent == 0 ? std::string() : std::string(symbol) + "^" + std::to_string(exponent) + " ";
    };
    std::string unit = power("m", axis.length) + power("N", axis.force) + power("K", axis.temperature);
    unit.pop_back();
    if (!parsed(unit)) return std::nullopt;
    return AxisUnit{unit, 1.0 / (std::pow(units.length, axis.length) * std::pow(units.force, axis.force) *
                                 std::pow(units.temperature, axis.temperature))};
  }
  const DataType* type = data_type(axis.type);
  if (type == nullptr) return std::nullopt;
  const bool rotation = is_rotation(direction);
  const int length = rotation ? type->rotation_length : type->length;
  const int force = rotation ? type->rotation_force : type->force;
  return AxisUnit{std::string(rotation ? type->rotation_unit : type->unit),
                  1.0 / (std::pow(units.length, length) * std::pow(units.force, force))};
}

std::string bracketed(const std::string& unit) { return "(" + unit + ")"; }

/// Whether the label of a numerator holds the unit of the whole quotient.
bool holds_quotient(const UniversalAxis& numerator, const AxisUnit& plain, int response, const AxisUnit& below) {
  const auto label = parsed(plain.unit), denominator = parsed(below.unit);
  if (!label || !denominator) return plain.unit.find('/') != std::string::npos && plain.unit.ends_with(below.unit);
  const auto expected = si_of(numerator, response, {});
  if (expected && parsed(plain.unit, expected->unit)) return false;
  if (expected) return parsed(plain.unit, bracketed(expected->unit) + "/" + bracketed(below.unit)).has_value();
  const std::string written = plain.unit + ")";
  return plain.unit.ends_with("/" + below.unit) || written.find("1/" + below.unit + ")") != std::string::npos;
}

}  // namespace

std::string quantity_of(const UniversalAxis& axis, int direction, const std::string& unit) {
  if (const DataType* type = data_type(axis.type))
    return std::string(is_rotation(direction) ? type->rotation : type->quantity);
  for (const auto& type : data_types) {
    if (type.number == 3 || unit.empty() || type.number >= 16) continue;
    if (parsed(unit, std::string(type.unit))) return std::string(type.quantity);
    if (type.unit != type.rotation_unit && parsed(unit) &&
        parsed(unit)->dimension == parse_unit(type.rotation_unit).dimension)
      return std::string(type.rotation);
  }
  return {};
}

int data_type_of(const std::string& quantity, const std::string& unit) {
  const std::string name = quantity.empty() ? quantity_of({}, 0, unit) : quantity;
  constexpr int reaction = 9;  // a measured force is an excitation force, 13
  for (const auto& type : data_types)
    if (type.number != reaction && (type.quantity == name || type.rotation == name)) return type.number;
  return 0;
}

AxisUnit unit_of(const UniversalAxis& axis, int direction, const UniversalUnits& units) {
  const auto si = si_of(axis, direction, units);
  if (axis.unit.empty()) return si.value_or(AxisUnit{});
  AxisUnit labelled{axis.unit};
  if (!si || units.si()) return labelled;
  const auto label = parsed(axis.unit, si->unit);
  labelled.contradicts =
      label && std::abs(label->factor / parse_unit(si->unit).factor / si->factor - 1.0) > same_factor;
  return labelled;
}

AxisUnit unit_of_quotient(const UniversalAxis& numerator, int response, const UniversalAxis& denominator, int reference,
                          const UniversalUnits& units) {
  AxisUnit above = unit_of(numerator, response, units);
  const AxisUnit below = unit_of(denominator, reference, units);
  if (above.unit.empty() || below.unit.empty() || below.unit == "-") return above;
  if (!numerator.unit.empty() && holds_quotient(numerator, above, response, below)) return above;
  return {bracketed(above.unit) + "/" + bracketed(below.unit), above.factor / below.factor,
          above.contradicts || below.contradicts};
}

}  // namespace kalfem
