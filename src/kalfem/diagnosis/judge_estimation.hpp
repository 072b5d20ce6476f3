#pragma once

#include "kalfem/identification/robust_deviations.hpp"
#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

/// What the numbers of an estimation say about themselves, without the cause: what innovations, substeps, unknowns and
/// the open loop contradict. Of a filter that stopped only that, as "failed": what it left would say again that there
/// is nothing.
Verdict verdict_of(const RecordEstimate& estimate);

}  // namespace kalfem
