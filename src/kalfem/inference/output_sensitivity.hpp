// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/inference/inference_problem.hpp"
#include "kalfem/inference/inference_result.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {

/// Sobol' indices of the outputs that the problem names, over its priors: natural frequencies with every connector as
/// stiff as at rest, largest connector forces of the simulation under the known excitation, and the mean NIS of the
/// record. Throws InvalidInput where the excitation is not known, or no output can be computed.
std::vector<OutputSensitivity> output_sensitivity(const InferenceProblem& problem, const Record& record);

}  // namespace kalfem
