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

}  // namespace kalfem
