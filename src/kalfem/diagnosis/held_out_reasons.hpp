// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/identification/record_estimate.hpp"
#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

/// The reason `band_too_narrow` where a sensor, predicted from all others, contradicts its band: those of quantities
/// that no sensor measures do not hold either. Process noise that mends it is the remedy.
std::vector<Reason> held_out_reasons(const RecordEstimate& estimate);

}  // namespace kalfem
