#pragma once

#include "kalfem/pipeline/run_study.hpp"

namespace kalfem {

/// Runs an augmented model of the case over the simulated or measured record. `failure` says in words why the numbers
/// are not usable.
EstimationOutcome run_estimation(const Study& study, const AugmentedModelSetup& setup, const StudyResults& results,
                                 const Progress& progress, std::string& failure);

/// Drives the case's substructure, as `model` holds it, by the estimated motion of its boundary and compares with the
/// reference.
PredictionOutcome run_prediction(const Study& study, const CoupledModel& model, const StudyResults& results,
                                 const Progress& progress);

}  // namespace kalfem
