// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bindings.hpp"

namespace kalfem::python {

/// Priors by parameter, each a dictionary of its shape: {"uniform": [lower, upper]}, {"normal": [mean, std]} or
/// {"lognormal": [median, std of the logarithm]}, the last two with "bounds" if they are cut. Texts may carry units; a
/// normal one's std may be a percentage of its mean. Throws InvalidInput by the prior's name.
std::vector<std::pair<std::string, MarginalPrior>> priors_of(const Structure& structure, const py::dict& given);

}  // namespace kalfem::python
