// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/units.hpp"

namespace kalfem {

/// A standard deviation or a walk in SI, which the case gives in `unit` or in per cent of |about|. Throws InvalidInput,
/// with its place, where it is negative or a percentage of 0.
double spread_about(const Located<Quantity>& given, const std::string& unit, double about);

/// The number of a random walk, which is per square root of a second: in `unit` alone where the case gives it with
/// that, "20 N/m/sqrt(s)", and as it stands otherwise.
Located<Quantity> walk_in(Located<Quantity> given, const std::string& unit);

}  // namespace kalfem
