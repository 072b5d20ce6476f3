// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/estimation/estimate.hpp"
#include "kalfem/identification/record_estimate.hpp"

namespace kalfem {

/// One pass of an estimate's filter over its record again: its filter, noise, outliers and samples that are held out,
/// without series of the states.
EstimationOptions rerun_options(const FilterRun& run, const EstimationSettings& settings,
                                const RecordEstimate& estimate);

}  // namespace kalfem
