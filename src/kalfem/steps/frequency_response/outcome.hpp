// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/vibration/computed_response.hpp"

namespace kalfem {

/// Frequency responses of the case's structure.
using FrequencyResponseOutcome = FrequencyResponses;

}  // namespace kalfem
