// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/pipeline/likelihood_checkpoint.hpp"

namespace kalfem {

/// Computes the posterior of a record by the plan's method into `outcome`; the likelihood that it rests on. `estimate`:
/// of the same record; null where there is none, which method: filter needs. Throws InvalidInput where no start has a
/// likelihood or the filter stopped, and Interrupted.
CaseLikelihood posterior_of_record(const Study& study, const Record& record, const RecordEstimate* estimate,
                                   LikelihoodCheckpoint& checkpoint, const Progress& progress,
                                   InferenceOutcome& outcome);

/// The same of the comparisons of its updating.
CaseLikelihood posterior_of_comparisons(const Study& study, const StudyResults& results,
                                        LikelihoodCheckpoint& checkpoint, const Progress& progress,
                                        InferenceOutcome& outcome);

}  // namespace kalfem
