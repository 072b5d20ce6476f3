// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "kalfem/api/update.hpp"
#include "kalfem/identification/parameterised_structure.hpp"
#include "kalfem/updating/residual.hpp"

namespace kalfem {

/// A comparison of the options as a residual.
struct MadeComparison {
  std::string name;
  std::vector<ResidualPtr> continuation;  ///< the same residual from the smoothest to the one that counts
  double weight = 1.0;
};

/// The frequencies of the options, if there are any, then their comparisons. Throws InvalidInput with everything that
/// does not fit, by its place. `connectors`: parameters of connectors among those that are varied.
std::vector<MadeComparison> make_comparisons(const Structure& structure, const StructurePtr& model,
                                             const std::shared_ptr<const ParameterisedStructure>& parameterised,
                                             const std::vector<UpdatingParameter>& parameters,
                                             const UpdateOptions& options,
                                             const std::vector<StructureBinding>& connectors = {});

}  // namespace kalfem
