#pragma once

#include "kalfem/diagnosis/diagnose.hpp"
#include "kalfem/identification/record_estimate.hpp"

namespace kalfem {

/// Which mistake explains an estimation whose filter stopped or whose numbers contradict themselves. Nothing if they do
/// not, if no mistake could be behind it, or if the problem's settings do not ask for it. `parts`: those that the
/// filter's model was made of.
std::optional<Diagnosis> look_for_cause(const EstimationProblem& problem, const StructureParts& parts,
                                        const Record& record, const RecordEstimate& estimate);

}  // namespace kalfem
