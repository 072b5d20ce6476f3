// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/api/update.hpp"
#include "kalfem/api/update_comparisons.hpp"
#include "kalfem/identification/parameter_set.hpp"

namespace kalfem {

/// The parameters of an updating, looked up.
struct Refined {
  std::vector<UpdatingParameter> parameters;
  std::vector<StructureBinding> bindings;
};

/// Throws InvalidInput with every parameter that does not exist or cannot start where it should.
Refined refined(const StructureModel& structure, const UpdateOptions& options);

/// Throws InvalidInput with every factor that makes stiffness or mass indefinite at a bound.
void require_definite(const StructurePtr& structure, const Refined& refined);

std::vector<std::string> names_of_parameters(const UpdateOptions& options);

/// The weighted sum of comparisons at one step of their continuation; the last one counts for those that have fewer.
ResidualSum sum_of(const std::vector<MadeComparison>& comparisons, std::size_t step);

/// The residual at the initial values with its Jacobian. Throws InvalidInput where there is none, and with every
/// parameter that no comparison depends on.
ResidualValue first_values(const ResidualSum& residual, const std::vector<UpdatingParameter>& parameters);

}  // namespace kalfem
