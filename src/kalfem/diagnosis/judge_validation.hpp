// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

struct Validation;

/// What speaks against the parameters that were tried: see validation_reasons(). A validation without comparison is
/// one reason, "validation_failed".
std::vector<Reason> reasons_of(const Validation& validation);

}  // namespace kalfem
