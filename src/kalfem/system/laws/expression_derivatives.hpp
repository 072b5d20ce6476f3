// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/system/laws/expression_tape.hpp"

namespace kalfem {

/// Adds the derivatives of a value by the variables to the tape, and returns their numbers in that order. A branch that
/// is not taken may have no number: it adds nothing.
std::vector<int> differentiate(ExpressionTape& tape, int value, const std::vector<int>& variables);

}  // namespace kalfem
