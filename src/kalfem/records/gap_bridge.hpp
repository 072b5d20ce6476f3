// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/records/record_preparation.hpp"

namespace kalfem {

/// Fills gaps of an input, which a model needs at every instant: missing samples take the values of the natural cubic
/// spline through the samples of their channel. A gap's length is the time between the samples at its sides; `longest`
/// [s] is the most that is bridged. What was filled is added to the preparation in words. Throws InvalidInput with the
/// time and length of every longer gap, and where samples are missing at an end.
void bridge_gaps(PreparedRecord& prepared, double longest);

}  // namespace kalfem
