// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>

#include "kalfem/yaml/yaml_node.hpp"

namespace kalfem {

/// The unit in which a case states each unknown and each updated parameter, by its name: "kN/m" of `initial: 30 kN/m`,
/// or of its prior or truth where the first has none. No entry where the case writes bare numbers or percentages.
std::map<std::string, std::string> written_units(const CaseSource& source);

/// "kN/m" of "30 kN/m"; empty of a bare number, a percentage, zero, which is alike in all units, or what is no number
/// with a unit.
std::string unit_written_in(const std::string& text);

}  // namespace kalfem
