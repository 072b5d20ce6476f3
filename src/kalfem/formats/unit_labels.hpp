// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace kalfem {

/// A unit as parse_unit() reads it where programs write it out ("Volts", "Newton", "[g]", "m/sec^2"); as it is where it
/// is not known; empty for words that mean none.
std::string understood_unit(std::string label);

}  // namespace kalfem
