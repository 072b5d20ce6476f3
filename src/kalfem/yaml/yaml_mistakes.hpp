// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

/// What is wrong with a text at whose `line` a parser of YAML stopped with `symptom`: a tab in the indentation, or a
/// line whose indentation fits no line above it; where neither is the cause, the symptom. `name` is that of the file.
Issue yaml_mistake(const std::string& text, const std::string& name, int line, const std::string& symptom);

}  // namespace kalfem
