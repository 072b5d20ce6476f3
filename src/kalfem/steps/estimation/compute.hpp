// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "kalfem/identification/augmented_model_setup.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/study_results.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// Runs an augmented model of the case over the simulated or measured record, in bases of finite elements that suit the
/// estimates: `setup` is replaced where they need others. `updated`: parameters that an updating found.
/// `on_first_answer` gets the first answer, if it is given.
EstimationOutcome run_estimation(const Study& study, AugmentedModelSetup& setup, const StudyResults& results,
                                 const std::vector<std::string>& updated, const Progress& progress,
                                 const std::function<void(EstimationOutcome)>& on_first_answer);

/// Estimates the record with each of the case's other laws too, and weighs all laws by their evidence p(y), which is
/// the filter's own likelihood with the unknowns integrated out. Motions and forces of `outcome` become the mixture,
///     mean = sum w_i m_i,    variance = sum w_i (s_i^2 + (m_i - mean)^2).
/// The law of a filter that stops has no weight.
void run_alternatives(const Study& study, const StudyResults& results, const Progress& progress,
                      EstimationOutcome& outcome);

}  // namespace kalfem
