#pragma once

#include "kalfem/identification/record_estimate.hpp"
#include "kalfem/verdict/checks.hpp"
#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

/// The innovations of a run of the filter over what the sensors measured, those before sample `first` not counting.
InnovationRecord innovations_of(const Record& measured, const EstimationResult& result, Eigen::Index first);
/// Those of an estimation: after settling.
InnovationRecord innovations_of(const RecordEstimate& estimate);

/// What the numbers of an estimation say about themselves, without the cause: what innovations, substeps, unknowns and
/// the open loop contradict. Of a filter that stopped only that, as "failed": what it left would say again that there
/// is nothing.
Verdict verdict_of(const RecordEstimate& estimate);

}  // namespace kalfem
