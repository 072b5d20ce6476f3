#pragma once

#include "kalfem/pipeline/run_study.hpp"

namespace kalfem {

/// Drives the case's substructure, as `model` holds it, by the estimated motion of its boundary and compares with the
/// reference.
PredictionOutcome run_prediction(const Study& study, const CoupledModel& model, const StudyResults& results,
                                 const Progress& progress);

}  // namespace kalfem
