// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/page/page.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/prediction/outcome.hpp"
#include "kalfem/study/structural_modifications.hpp"

namespace kalfem {

/// The linear substructure driven by its estimated boundary motion.
Section prediction_section(const Study& study, const EstimationOutcome& estimation, const PredictionOutcome& outcome);

/// Natural frequencies of each modification.
Table modification_table(const std::vector<StructuralModificationResult>& modifications);

}  // namespace kalfem
