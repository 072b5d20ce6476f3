// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/steps/prediction/outcome.hpp"
#include "kalfem/steps/study_results.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// Drives the case's substructure, as `model` holds it, by the estimated motion of its boundary and compares with the
/// reference.
PredictionOutcome run_prediction(const Study& study, const CoupledModel& model, const StudyResults& results,
                                 const Progress& progress);

}  // namespace kalfem
