// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/identification/finite_element_part.hpp"

namespace kalfem {

/// The superelement of a part for frequency responses up to a frequency [Hz], without the comparison with the full
/// model. The degrees of freedom `loaded`, at which forces act, are kept beside the boundary.
Superelement reduce_for_responses(const FiniteElementPart& part, const ReductionRequest& request,
                                  const std::vector<std::string>& loaded, double highest);

}  // namespace kalfem
