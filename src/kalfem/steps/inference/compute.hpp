// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/steps/inference/likelihood_checkpoint.hpp"
#include "kalfem/steps/inference/outcome.hpp"
#include "kalfem/steps/run_study.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// What a record can tell of the parameters before it is looked at: the information of the record that is expected at
/// the initial values under the known excitation, over the time of the case's record or simulation. Empty where it
/// cannot be foreseen.
std::optional<Identifiability> identifiability_before(const Study& study);

/// What the case's `infer` asks for, of the simulated or measured record, or of the comparisons of its updating. Keeps
/// the likelihoods in the options' folder, from which a run that was killed continues.
InferenceOutcome run_inference(const Study& study, const StudyResults& results, const RunOptions& options);

/// Computes the posterior and the evidence of each law of infer.compare_laws on the same record, and tries its
/// posterior on the part of the record that `validate` holds back, if there is one.
LawRanking rank_laws(const Study& study, const Record& record, LikelihoodCheckpoint& checkpoint,
                     const Progress& progress);

/// Sobol' indices of the outputs that the case names, over its priors: natural frequencies with every connector as
/// stiff as at rest, largest connector forces of the simulation under the known excitation, and the mean NIS of the
/// record. Throws InvalidInput where the excitation is not known, or no output can be computed.
std::vector<OutputSensitivity> output_sensitivity(const Study& study, const Record& record, int threads);

/// Whether parameters that are inferred make a simulation of the record: its excitation is known, every unknown of the
/// structure is inferred, and the filter has no local model.
bool can_be_simulated(const Study& study);

/// Response at some draws of the posterior beside the record: the simulation under the known excitation through every
/// sensor, 95 % of it with the sensor's noise. Empty where it cannot be
/// simulated, or no simulation ran to its end.
std::vector<PredictiveBand> predictive_bands(const Study& study, const Record& record, const SampleSet& samples,
                                             int threads);

}  // namespace kalfem
