// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/inference/parameter_likelihood.hpp"
#include "kalfem/steps/study_results.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// The likelihood of a case's inferred parameters by the comparisons of its updating,
///     ln p = -|r|^2 / 2 - N/2 ln(2 pi)
/// of the N weighted residuals r in their standard deviations.
ParameterLikelihood likelihood_of_comparisons(const Study& study, const StudyResults& results);

}  // namespace kalfem
