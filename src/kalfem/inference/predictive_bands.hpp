// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/inference/inference_problem.hpp"
#include "kalfem/inference/inference_result.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {

/// Whether parameters that are inferred make a simulation of the record: its excitation is known, every unknown of the
/// structure is inferred, and the filter has no local model.
bool can_be_simulated(const InferenceProblem& problem);

/// Response at some draws of the posterior beside the record: the simulation under the known excitation through every
/// sensor, 95 % of it with the sensor's noise. Empty where it cannot be simulated, or no simulation ran to its end.
std::vector<PredictiveBand> predictive_bands(const InferenceProblem& problem, const Record& record,
                                             const SampleSet& samples);

}  // namespace kalfem
