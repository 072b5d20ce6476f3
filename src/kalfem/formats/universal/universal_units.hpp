// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "kalfem/records/measured_file.hpp"

namespace kalfem {

/// Units of a universal file as dataset 164 states them: a number of the file divided by its factor is in SI. Without
/// the dataset the file is in SI.
struct UniversalUnits {
  double length = 1.0;
  double force = 1.0;
  double temperature = 1.0;
  [[nodiscard]] bool si() const { return length == 1.0 && force == 1.0; }
};

/// What one axis of a function holds (records 8 to 11 of dataset 58).
struct UniversalAxis {
  int type = 0;  ///< specific data type: 0 unknown, 1 general, 8 displacement, 11 velocity, 12 acceleration, ...
  int length = 0, force = 0, temperature = 0;  ///< exponents, which count for the type 1 alone
  std::string label = {};
  std::string unit = {};  ///< its label, empty where it is NONE
};

/// The unit of the numbers of an axis once they are multiplied by `factor`.
struct AxisUnit {
  std::string unit;
  double factor = 1.0;
  bool contradicts = false;  ///< the label names another unit than dataset 164; the label holds
};

/// "acceleration", "force", ... by the specific data type, else by the unit; empty where neither tells it. The
/// direction tells a rotation from a translation.
std::string quantity_of(const UniversalAxis& axis, int direction, const std::string& unit);

/// The unit that the label names; without a label SI, into which the factor converts from the units of the file.
AxisUnit unit_of(const UniversalAxis& axis, int direction, const UniversalUnits& units);

/// The unit of a quotient of two axes, such as that of a frequency response. Some programs write the unit of the whole
/// quotient into the label of the numerator.
AxisUnit unit_of_quotient(const UniversalAxis& numerator, int response, const UniversalAxis& denominator, int reference,
                          const UniversalUnits& units);

/// The specific data type of a quantity, as quantity_of() names it, or of a unit where the quantity is empty; 0 where
/// there is none.
int data_type_of(const std::string& quantity, const std::string& unit);

}  // namespace kalfem
