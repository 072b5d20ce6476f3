// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/validation/validation.hpp"

namespace kalfem {

/// The estimates on data that they were not estimated from, and beside it the same on those that they were.
using ValidationOutcome = Validation;

}  // namespace kalfem
