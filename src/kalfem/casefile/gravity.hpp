// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <initializer_list>

#include "kalfem/casefile/description.hpp"

namespace kalfem::description {

/// The letter g is the gram, and beside an acceleration standard gravity. `value` was read at `path` below the node,
/// before it was known that it is an acceleration: "0.02 g" becomes 0.196 m/s^2.
void take_gravity(const CaseNode& node, std::initializer_list<const char*> path, Value& value);

}  // namespace kalfem::description
