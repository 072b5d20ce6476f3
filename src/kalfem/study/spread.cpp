// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/spread.hpp"

#include <cmath>

#include "kalfem/yaml/bounds.hpp"

namespace kalfem {

double spread_about(const Located<Quantity>& given, const std::string& unit, double about) {
  const bool percentage = !given.value.bare && given.value.dimension == Dimension{};
  if (!percentage) return checked_number(given, unit, Bounds::nonnegative());
  if (given.value.value < 0.0)
    throw InvalidInput(given.issue(shortest(100.0 * given.value.value) + " % given", "it must be >= 0"));
  if (about == 0.0)
    throw InvalidInput(
        given.issue("per cent of a value of 0 is given", "this would be 0", "give it in the parameter's unit"));
  return given.value.value * std::abs(about);
}

Located<Quantity> walk_in(Located<Quantity> given, const std::string& unit) {
  const std::string number = unit.empty() || unit == "-" ? "1" : unit;
  if (!given.value.bare && given.value.dimension == parse_unit(number + "/sqrt(s)").dimension)
    given.value.dimension = parse_unit(number).dimension;
  return given;
}

}  // namespace kalfem
