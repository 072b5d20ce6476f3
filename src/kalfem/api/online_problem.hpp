// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/api/estimate.hpp"
#include "kalfem/live/online_steps.hpp"

namespace kalfem {

/// What a filter over a structure's samples is made of. Throws InvalidInput as OnlineFilter does.
FilterProblem online_problem(const Structure& structure, double sample_rate, const EstimateOptions& options);

/// The inputs of a structure; those without a signal come online.
std::vector<OnlineInput> online_inputs(const Structure& structure);

}  // namespace kalfem
