// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/inference/inference_result.hpp"

namespace kalfem {

/// What the data tell of the parameters.
using InferenceOutcome = InferenceResult;

}  // namespace kalfem
