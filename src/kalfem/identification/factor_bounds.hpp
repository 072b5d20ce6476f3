// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/identification/updating_setup.hpp"

namespace kalfem {

/// Factors of parts (PartFactor) whose bounds leave the structures: with all other parameters at their initial values,
/// stiffness or mass has a negative eigenvalue at a bound, or grows toward one without an upper bound. As K and M are
/// affine in a factor, they are then positive semi-definite between its bounds, too. Each with the parameter's name.
/// Only factors of matrices, and those with a negative bound, are tried: matrices of elements have no such eigenvalue.
std::vector<std::pair<std::string, Issue>> indefinite_at_bounds(const StructurePtr& structure,
                                                                const UpdatingSetup& setup);

}  // namespace kalfem
