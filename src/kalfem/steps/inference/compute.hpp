// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "kalfem/steps/inference/outcome.hpp"
#include "kalfem/steps/run_study.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// What a record can tell of the parameters before it is looked at, over the time of the case's record or simulation.
/// Empty where it cannot be foreseen.
std::optional<Identifiability> identifiability_before(const Study& study);

/// What the sensors of an estimation tell of its unknowns and of unknown gains, by simulations about their initial
/// values over the first 4000 samples; nothing where the excitation is not known, or no simulation is possible.
std::optional<Identifiability> told_by_sensors(const Study& study);

/// What the case's `infer` asks for, of the simulated or measured record, or of the comparisons of its updating. Keeps
/// the likelihoods in the options' folder, from which a run that was killed continues.
InferenceOutcome run_inference(const Study& study, const StudyResults& results, const RunOptions& options);

}  // namespace kalfem
