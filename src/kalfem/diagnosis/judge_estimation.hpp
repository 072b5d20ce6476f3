// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/identification/robust_deviations.hpp"
#include "kalfem/verdict/checks.hpp"
#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

/// The unknowns after the last sample beside their priors, in the order of the filter's model.
std::vector<EstimatedUnknown> estimated_unknowns(const RecordEstimate& estimate);

/// What the numbers of an estimation say about themselves, without the cause: what innovations, substeps, unknowns and
/// the open loop contradict. Of a filter that stopped only that, as "failed": what it left would say again that there
/// is nothing.
Verdict verdict_of(const RecordEstimate& estimate);

}  // namespace kalfem
