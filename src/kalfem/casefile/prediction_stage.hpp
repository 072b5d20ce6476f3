#pragma once

#include "kalfem/casefile/stages.hpp"

namespace kalfem {

/// Throws InvalidInput where the substructure, as `model` holds it, has no boundary or interior, where its interior
/// moves freely, or where the observer does not estimate the motion of its boundary.
void check_driven(const Study& study, const CoupledModel& model, const description::Name& substructure);

/// Drives the case's substructure, as `model` holds it, by the estimated motion of its boundary and compares with the
/// reference.
PredictionStage predict_stage(const Study& study, const CoupledModel& model, const StudyResults& results,
                              const Progress& progress);

}  // namespace kalfem
