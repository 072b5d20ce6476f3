// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/inference/posterior_of_data.hpp"

namespace kalfem {

/// What the record tells of the parameters: the posterior by the problem's method,
///     p(theta | y) = p(y | theta) p(theta) / Z,
/// its evidence Z, the identifiability before and after, profiles, predictive bands and sensitivities as the problem
/// asks for them. Throws InvalidInput where no start has a likelihood or the filter stopped whose posterior is asked
/// for, and Interrupted.
InferenceResult infer(const InferenceProblem& problem, const Record& record, const InferenceAids& aids = {});

/// The same of other data, by their likelihood: without bands and sensitivities, which are those of a record.
InferenceResult infer(const InferenceProblem& problem, ParameterLikelihood likelihood, const InferenceAids& aids = {});

/// What a record can tell of the parameters before it is looked at: the information of the record that is expected at
/// the initial values under the known excitation. `time`: its samples; channels are not looked at. Empty where it
/// cannot be foreseen.
std::optional<Identifiability> expected_identifiability(const InferenceProblem& problem, const Record& time);

}  // namespace kalfem
