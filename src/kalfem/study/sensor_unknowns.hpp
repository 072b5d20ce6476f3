// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/identification/measurement_unknowns.hpp"
#include "kalfem/study/case_study.hpp"

namespace kalfem {

/// Adds an unknown of the measurement to the problem. Throws InvalidInput where there is no such sensor, and for
/// numbers that do not fit.
void add_measurement_unknown(const CaseStudy& study, const std::string& name, const description::Unknown& given,
                             EstimationProblem& problem);

}  // namespace kalfem
