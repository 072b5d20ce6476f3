#pragma once

#include "kalfem/casefile/stages.hpp"

namespace kalfem {

/// Runs an observer of the case over the simulated or measured record. `failure` says in words why the numbers are not
/// usable.
EstimationStage estimate_stage(const Study& study, const ObserverSetup& setup, const StudyResults& results,
                               const Progress& progress, std::string& failure);

}  // namespace kalfem
