#pragma once

#include "kalfem/pipeline/run_study.hpp"

namespace kalfem {

/// Runs an augmented model of the case over the simulated or measured record. `failure` says in words why the numbers
/// are not usable.
EstimationOutcome run_estimation(const Study& study, const AugmentedModelSetup& setup, const StudyResults& results,
                                 const Progress& progress, std::string& failure);

}  // namespace kalfem
