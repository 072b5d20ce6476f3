#pragma once

#include "kalfem/pipeline/run_study.hpp"

namespace kalfem {

/// Throws InvalidInput where the substructure, as `model` holds it, has no boundary or interior, where its interior
/// moves freely, or where the augmented model does not estimate the motion of its boundary.
void check_driven(const Study& study, const CoupledModel& model, const description::Name& substructure);

/// Drives the case's substructure, as `model` holds it, by the estimated motion of its boundary and compares with the
/// reference.
PredictionOutcome run_prediction(const Study& study, const CoupledModel& model, const StudyResults& results,
                                 const Progress& progress);

}  // namespace kalfem
