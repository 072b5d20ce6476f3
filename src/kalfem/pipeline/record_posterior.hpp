#pragma once

#include "kalfem/pipeline/case_likelihood.hpp"

namespace kalfem {

/// Computes the posterior of a record by the plan's method into `outcome`; the likelihood that it rests on. `estimate`:
/// of the same record; null where there is none, which method: filter needs. Throws InvalidInput where no start has a
/// likelihood or the filter stopped, and Interrupted.
CaseLikelihood posterior_of_record(const Study& study, const Record& record, const RecordEstimate* estimate,
                                   int threads, const Progress& progress, InferenceOutcome& outcome);

}  // namespace kalfem
