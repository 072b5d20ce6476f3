// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/pipeline/run_study.hpp"

namespace kalfem {

/// What a record can tell of the parameters before it is looked at: the information of the record that is expected at
/// the initial values under the known excitation, over the time of the case's record or simulation. Empty where it
/// cannot be foreseen.
std::optional<Identifiability> identifiability_before(const Study& study);

/// What the case's `infer` asks for, of the simulated or measured record, or of the comparisons of its updating. Keeps
/// the likelihoods in the options' folder, from which a run that was killed continues.
InferenceOutcome run_inference(const Study& study, const StudyResults& results, const RunOptions& options);

}  // namespace kalfem
