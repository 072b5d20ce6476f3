// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <string>

#include "kalfem/base/units.hpp"

namespace kalfem {

/// A number for a sentence, with three digits that count.
inline std::string three_digits(double value) {
  if (value == 0.0 || !std::isfinite(value)) return shortest(value);
  const double scale = std::pow(10.0, 2.0 - std::floor(std::log10(std::abs(value))));
  return shortest(std::round(value * scale) / scale);
}

}  // namespace kalfem
