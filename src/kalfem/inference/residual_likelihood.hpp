// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "kalfem/inference/parameter_likelihood.hpp"
#include "kalfem/updating/residual.hpp"

namespace kalfem {

/// The likelihood by what a model is compared with,
///     ln p = -|r|^2 / 2 - N/2 ln(2 pi)
/// of the N weighted residuals r in their standard deviations, -infinity where the model has no response; its
/// information is J^T J. `words`: what is compared. `dofs`: of the models, from which its work follows (assembly and
/// modes of each, and a solution for each number that is compared).
ParameterLikelihood likelihood_of_residual(const std::shared_ptr<const ResidualSum>& residual,
                                           std::vector<std::string> names, std::string words, Eigen::Index dofs);

}  // namespace kalfem
