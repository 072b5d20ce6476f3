#pragma once

#include "kalfem/casefile/stages.hpp"

namespace kalfem {

/// Drives the case's substructure, as `model` holds it, by the estimated motion of its boundary and compares with the
/// reference.
PredictionStage predict_stage(const Study& study, const CoupledModel& model, const StudyResults& results,
                              const Progress& progress);

}  // namespace kalfem
